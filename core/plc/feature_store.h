// The features present, by id, with the users of each point and pair of points. No geometry. Not
// thread-safe; const members may run concurrently. Lookups O(1).
#ifndef DYNMESH_CORE_PLC_FEATURE_STORE_H_
#define DYNMESH_CORE_PLC_FEATURE_STORE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/container/inlined_vector.h"
#include "core/geometry/point.h"
#include "core/plc/cell_grid.h"
#include "core/plc/delta.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {

template <int D>
struct PointRecord {
  geometry::Point<D> p{};
  Slot slot = 0;  // in the spatial index
};

struct SegmentRecord {
  std::array<FeatureId, 2> ends{};
  Slot slot = 0;           // in the spatial index
  bool is_marked = false;  // unsplit, by itself
};

// Two points that are joined by an edge of polygons.
struct EdgeRecord {
  std::vector<FeatureId> polygons;  // ascending, at least one
  FeatureId segment = kNoFeature;   // the segment feature that joins them as well, if any
  Slot slot = 0;                    // in the spatial index, if there is no segment feature
  bool unsplit = false;             // for the sake of one of them, or of that segment
};

template <int D>
class FeatureStore {
 public:
  using Points = absl::flat_hash_map<FeatureId, PointRecord<D>>;
  using Segments = absl::flat_hash_map<FeatureId, SegmentRecord>;
  using Sizes = absl::flat_hash_map<FeatureId, SizeFeature<D>>;
  using Polygons = absl::flat_hash_map<FeatureId, Rings>;
  using Edges = absl::flat_hash_map<EdgeKey, EdgeRecord>;

  const PointRecord<D>* FindPoint(FeatureId id) const { return Find(points_, id); }
  const SegmentRecord* FindSegment(FeatureId id) const { return Find(segments_, id); }
  const SizeFeature<D>* FindSize(FeatureId id) const { return Find(sizes_, id); }
  const Rings* FindPolygon(FeatureId id) const { return Find(polygons_, id); }
  // Is there a feature of any kind with that id?
  bool Contains(FeatureId id) const {
    return FindPoint(id) != nullptr || FindSegment(id) != nullptr || FindSize(id) != nullptr ||
           FindPolygon(id) != nullptr;
  }
  // Is the polygon marked unsplit?
  bool IsUnsplit(FeatureId polygon) const {
    return !unsplit_polygons_.empty() && unsplit_polygons_.contains(polygon);
  }
  const EdgeRecord* FindEdge(const EdgeKey& key) const { return Find(edges_, key); }
  // The segment feature between two points, kNoFeature if there is none. O(segments at one of
  // them).
  FeatureId SegmentBetween(const EdgeKey& key) const {
    const auto at_p = SegmentsAt(key.first), at_q = SegmentsAt(key.second);
    for (const FeatureId id : at_p.size() < at_q.size() ? at_p : at_q) {
      const auto& ends = segments_.at(id).ends;
      if (KeyOf(ends[0], ends[1]) == key) return id;
    }
    return kNoFeature;
  }
  // The segments that end at a point, in no particular order.
  std::span<const FeatureId> SegmentsAt(FeatureId point) const {
    const auto it = segments_at_.find(point);
    return it == segments_at_.end() ? std::span<const FeatureId>() : it->second;
  }
  // The polygons and sizing polygons with a corner at a point, in no particular order, maybe twice.
  std::span<const FeatureId> PolygonsAt(FeatureId point) const {
    const auto it = corners_.find(point);
    return it == corners_.end() ? std::span<const FeatureId>() : it->second.users;
  }
  // The other ends of the edges of polygons at a point, in no particular order.
  std::span<const FeatureId> EdgesAt(FeatureId point) const {
    const auto it = corners_.find(point);
    return it == corners_.end() ? std::span<const FeatureId>() : it->second.ends;
  }
  std::size_t size() const {
    return points_.size() + segments_.size() + sizes_.size() + polygons_.size();
  }
  // Approximate.
  std::size_t bytes() const {
    const auto of = [](const auto& map) { return map.capacity() * (sizeof(*map.begin()) + 1); };
    return of(points_) + of(segments_) + of(sizes_) + of(polygons_) + of(edges_) +
           of(segments_at_) + of(corners_) + of(facet_slots_) + of(unsplit_polygons_);
  }
  const Points& points() const { return points_; }
  const Segments& segments() const { return segments_; }
  const Sizes& sizes() const { return sizes_; }
  const Polygons& polygons() const { return polygons_; }
  const Edges& edges() const { return edges_; }

  // The segment with its ends' positions. REQUIRES: `record` is that of segment `id` here.
  SegmentFeature<D> Expand(FeatureId id, const SegmentRecord& record) const {
    const auto [p, q] = record.ends;
    SegmentFeature<D> f = {id, p, q, points_.at(p).p, points_.at(q).p};
    f.is_marked = f.unsplit = record.is_marked;
    if (edges_.empty()) return f;
    if (const EdgeRecord* edge = FindEdge(KeyOf(p, q))) {
      f.polygons = edge->polygons;
      f.unsplit = edge->unsplit;
    }
    return f;
  }
  // An edge of polygons without a segment feature.
  SegmentFeature<D> Expand(const EdgeKey& key, const EdgeRecord& record) const {
    const auto [p, q] = key;
    SegmentFeature<D> f = {record.polygons.front(), p, q, points_.at(p).p, points_.at(q).p};
    f.polygons = record.polygons;
    f.unsplit = record.unsplit;
    return f;
  }

  // A 3D polygon with its corners' positions.
  FacetFeature FacetOf(FeatureId id, const Rings& rings) const {
    FacetFeature facet{id, rings, {}};
    for (const auto& ring : rings) {
      auto& positions = facet.positions.emplace_back();
      for (const FeatureId point : ring) positions.push_back(points_.at(point).p);
    }
    return facet;
  }

  // Reserves room for so many more.
  void Reserve(std::size_t points, std::size_t segments) {
    points_.reserve(points_.size() + points);
    segments_.reserve(segments_.size() + segments);
  }
  // REQUIRES: the id is free; a segment's ends are points present.
  void Add(const PointFeature<D>& f, Slot slot) {
    PointRecord<D>& record = points_[f.id];
    record.p = f.p;
    record.slot = slot;
  }
  void Add(const SegmentFeature<D>& f, Slot slot) {
    if (!f.polygons.empty()) {
      const bool of_polygon = f.IsOfPolygon();
      edges_[KeyOf(f)] = {f.polygons, of_polygon ? kNoFeature : f.id, slot, f.unsplit};
      corners_[f.p_id].ends.push_back(f.q_id);
      corners_[f.q_id].ends.push_back(f.p_id);
      if (of_polygon) return;
    }
    segments_[f.id] = {{f.p_id, f.q_id}, slot, f.is_marked};
    segments_at_[f.p_id].push_back(f.id);
    segments_at_[f.q_id].push_back(f.id);
  }
  void Add(const SizeFeature<D>& f) {
    sizes_[f.id] = f;
    AddCorners(f.id, f.rings);
  }
  void Add(const PolygonFeature& f) {
    polygons_[f.id] = f.rings;
    if (f.unsplit) unsplit_polygons_.insert(f.id);
    AddCorners(f.id, f.rings);
  }
  // Stores the slot only: the rings are the polygon's.
  void AddFacet(FeatureId id, Slot slot) { facet_slots_[id] = slot; }
  // REQUIRES: present; no feature needs a removed point.
  void RemovePoint(FeatureId id) { points_.erase(id); }
  void RemoveSize(FeatureId id) {
    RemoveCorners(id, sizes_.at(id).rings);
    sizes_.erase(id);
  }
  void RemovePolygon(FeatureId id) {
    RemoveCorners(id, polygons_.at(id));
    polygons_.erase(id);
    unsplit_polygons_.erase(id);
  }
  // Returns its slot in the spatial index.
  Slot RemoveFacet(FeatureId id) {
    const auto it = facet_slots_.find(id);
    const Slot slot = it->second;
    facet_slots_.erase(it);
    return slot;
  }
  Slot Remove(const SegmentFeature<D>& f) {
    Slot slot = 0;
    if (!f.polygons.empty()) {
      const auto edge = edges_.find(KeyOf(f));
      slot = edge->second.slot;
      edges_.erase(edge);
      EraseOne(corners_, f.p_id, &Corner::ends, f.q_id);
      EraseOne(corners_, f.q_id, &Corner::ends, f.p_id);
      if (f.IsOfPolygon()) return slot;
    }
    const auto segment = segments_.find(f.id);
    slot = segment->second.slot;
    segments_.erase(segment);
    for (const FeatureId end : {f.p_id, f.q_id}) {
      const auto at = segments_at_.find(end);
      at->second.erase(std::find(at->second.begin(), at->second.end(), f.id));
      if (at->second.empty()) segments_at_.erase(at);
    }
    return slot;
  }

 private:
  // The polygons at a point.
  struct Corner {
    std::vector<FeatureId> users, ends;
  };
  using Corners = absl::flat_hash_map<FeatureId, Corner>;

  template <typename Map>
  static const typename Map::mapped_type* Find(const Map& map, const typename Map::key_type& key) {
    if (map.empty()) return nullptr;
    const auto it = map.find(key);
    return it == map.end() ? nullptr : &it->second;
  }
  static void EraseOne(Corners& corners, FeatureId point, std::vector<FeatureId> Corner::*list,
                       FeatureId id) {
    const auto it = corners.find(point);
    std::vector<FeatureId>& ids = it->second.*list;
    ids.erase(std::find(ids.begin(), ids.end(), id));
    if (it->second.users.empty() && it->second.ends.empty()) corners.erase(it);
  }
  void AddCorners(FeatureId id, const Rings& rings) {
    for (const auto& ring : rings) {
      for (const FeatureId point : ring) corners_[point].users.push_back(id);
    }
  }
  void RemoveCorners(FeatureId id, const Rings& rings) {
    for (const auto& ring : rings) {
      for (const FeatureId point : ring) EraseOne(corners_, point, &Corner::users, id);
    }
  }

  Points points_;
  Segments segments_;
  Sizes sizes_;
  Polygons polygons_;
  absl::flat_hash_set<FeatureId> unsplit_polygons_;
  Edges edges_;
  // Not in the points' records: most points have none.
  absl::flat_hash_map<FeatureId, absl::InlinedVector<FeatureId, 2>> segments_at_;
  Corners corners_;
  absl::flat_hash_map<FeatureId, Slot> facet_slots_;  // of 3D polygons
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FEATURE_STORE_H_
