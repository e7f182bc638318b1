// The features present, by id, and which segments use a point. No geometry.
// Not thread-safe; const members may run at the same time. Lookups O(1).
#ifndef DYNMESH_CORE_PLC_FEATURE_STORE_H_
#define DYNMESH_CORE_PLC_FEATURE_STORE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "core/geometry/point.h"
#include "core/plc/chord_list.h"
#include "core/plc/delta.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {

struct PointRecord {
  geometry::Point2 p{};
  Slot slot = 0;  // in the spatial index
};

struct SegmentRecord {
  std::array<FeatureId, 2> ends{};
  Slot slot = 0;  // in the spatial index
};

class FeatureStore {
 public:
  using Points = absl::flat_hash_map<FeatureId, PointRecord>;
  using Segments = absl::flat_hash_map<FeatureId, SegmentRecord>;
  using Sizes = absl::flat_hash_map<FeatureId, SizeFeature>;

  const PointRecord* FindPoint(FeatureId id) const { return Find(points_, id); }
  const SegmentRecord* FindSegment(FeatureId id) const { return Find(segments_, id); }
  const SizeFeature* FindSize(FeatureId id) const { return Find(sizes_, id); }
  // The segments that end at a point, in no order.
  std::span<const FeatureId> SegmentsAt(FeatureId point) const {
    const auto it = segments_at_.find(point);
    return it == segments_at_.end() ? std::span<const FeatureId>() : it->second;
  }
  std::size_t size() const { return points_.size() + segments_.size() + sizes_.size(); }
  const Points& points() const { return points_; }
  const Segments& segments() const { return segments_; }
  const Sizes& sizes() const { return sizes_; }

  // The segment with its ends' places. REQUIRES: `record` is of segment `id` here.
  SegmentFeature Expand(FeatureId id, const SegmentRecord& record) const {
    const auto [p, q] = record.ends;
    return {id, p, q, points_.at(p).p, points_.at(q).p};
  }

  // Room for that many more.
  void Reserve(std::size_t points, std::size_t segments) {
    points_.reserve(points_.size() + points);
    segments_.reserve(segments_.size() + segments);
  }
  // REQUIRES: the id is free; a segment's ends are points present.
  void Add(const PointFeature& f, Slot slot) {
    PointRecord& record = points_[f.id];
    record.p = f.p;
    record.slot = slot;
  }
  void Add(const SegmentFeature& f, Slot slot) {
    segments_[f.id] = {{f.p_id, f.q_id}, slot};
    segments_at_[f.p_id].push_back(f.id);
    segments_at_[f.q_id].push_back(f.id);
  }
  // REQUIRES: present; no segment ends at a removed point.
  void RemovePoint(FeatureId id) { points_.erase(id); }
  void Add(const SizeFeature& f) { sizes_[f.id] = f; }
  void RemoveSize(FeatureId id) { sizes_.erase(id); }
  void RemoveSegment(FeatureId id) {
    for (const FeatureId end : segments_.at(id).ends) {
      const auto at = segments_at_.find(end);
      auto& users = at->second;
      users.erase(std::remove(users.begin(), users.end(), id), users.end());
      if (users.empty()) segments_at_.erase(at);
    }
    segments_.erase(id);
  }

 private:
  template <typename Map>
  static const typename Map::mapped_type* Find(const Map& map, FeatureId id) {
    const auto it = map.find(id);
    return it == map.end() ? nullptr : &it->second;
  }

  Points points_;
  Segments segments_;
  Sizes sizes_;
  // Apart from the points: most have none.
  absl::flat_hash_map<FeatureId, absl::InlinedVector<FeatureId, 2>> segments_at_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FEATURE_STORE_H_
