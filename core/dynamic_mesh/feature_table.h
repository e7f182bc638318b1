// Maps the client's feature ids to the mesher's vertices, subsegments and small slots.
// Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_

#include <algorithm>
#include <iterator>
#include <memory>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/large_vector.h"
#include "core/base/steps.h"
#include "core/delaunay/delaunay_insert_order.h"
#include "core/dynamic_mesh/wedge_table.h"
#include "core/meshing/elements.h"
#include "core/meshing/facet_field.h"
#include "core/meshing/polygon_area.h"
#include "core/meshing/polyline.h"
#include "core/meshing/sizing_field.h"
#include "core/plc/delta.h"
#include "core/plc/text.h"
#include "core/regions/region_terms.h"
#include "core/regions/surface_table.h"
#include "core/regions/wall.h"
#include "dynmesh/feature.h"

namespace dynmesh {

template <int D>
class FeatureTable {
 public:
  using Point = geometry::Point<D>;
  using Delta = plc::Delta<D>;

  // Slot 0 is the domain box.
  FeatureTable() : ids_{kBoxFeature} {}

  FeatureId IdOf(meshing::FeatureSlot slot) const {
    return slot == meshing::kNil ? kNoFeature : ids_[slot];
  }

  // Applies a change of input to the refinement. Removals first; a feature is removed before, and
  // added after, those that it depends on. If `steps` stop, table and refinement are unusable.
  template <class Refinement>
  void Apply(const Delta& delta, Refinement& refinement, Steps& steps) {
    for (const plc::SizeFeature<D>& f : delta.removed_sizes) {
      const auto it = sizes_.find(f.id);
      refinement.RemoveSizing(it->second);
      sizes_.erase(it);
    }
    AddSizes(delta, refinement);
    RemoveFacets(delta, refinement);
    RemoveSegments(delta, refinement);
    for (const plc::PointFeature<D>& p : delta.removed_points) {
      const auto it = points_.find(p.id);
      FreeSlot(refinement.vertex(it->second).feature);
      refinement.RemovePoint(it->second);
      points_.erase(it);
    }
    AddOthers(delta, refinement, steps);
  }
  template <class Refinement>
  void Apply(const Delta& delta, Refinement& refinement) {
    AllSteps all;
    Apply(delta, refinement, all);
  }

  // The same for a change that only adds, of `refinement` that has no means to remove.
  template <class Refinement>
  void Add(const Delta& delta, Refinement& refinement, Steps& steps) {
    AddSizes(delta, refinement);
    AddOthers(delta, refinement, steps);
  }

  // Walls added or removed since Collect. A wall that only changed owners counts as removed and
  // added.
  const std::vector<Wall<D>>& toggled_walls() const { return toggled_walls_; }
  // The owners of the wall in that slot, ascending: the polygons (2D) or closed surfaces (3D) that
  // lie on one side of it. 2D: the polygons with an edge on the segment. 3D: the surfaces that the
  // facet is part of.
  std::span<const FeatureId> OwnersOfWall(meshing::FeatureSlot slot) const {
    if constexpr (D == 3) return surfaces_.SurfacesOf(ids_[slot]);
    if (walls_.empty()) return {};
    const auto it = walls_.find(slot);
    return it == walls_.end() ? std::span<const FeatureId>() : it->second;
  }

  // 3D: facets removed since Collect, and facets added since and still present.
  struct NewFacet {
    meshing::FeatureSlot slot;
    std::vector<meshing::VertexIndex> corners;
  };
  const std::vector<NewFacet>& new_facets() const { return new_facets_; }
  const std::vector<meshing::FeatureSlot>& gone_facets() const { return gone_facets_; }
  bool has_facets() const { return !facets_.empty(); }
  // Facets that stay but belong to other closed surfaces than before. Some may have been removed
  // since.
  const std::vector<meshing::FeatureSlot>& resurfaced_facets() const { return resurfaced_facets_; }

  // Slots of removed features keep their ids until this call.
  void Collect() {
    if (!walls_.empty()) {
      for (const meshing::FeatureSlot slot : freed_) walls_.erase(slot);
    }
    toggled_walls_.clear();
    new_facets_.clear();
    gone_facets_.clear();
    resurfaced_facets_.clear();
    free_.insert(free_.end(), freed_.begin(), freed_.end());
    freed_.clear();
  }

  std::size_t bytes() const {
    const auto of = [](const auto& map) { return map.capacity() * (sizeof(*map.begin()) + 1); };
    return of(points_) + of(sizes_) + of(facets_) + of(walls_) +
           ids_.capacity() * sizeof(FeatureId) +
           (free_.capacity() + freed_.capacity()) * sizeof(meshing::FeatureSlot) +
           segments_.bytes();
  }

 private:
  // For fewer points, sorting costs more than it saves.
  static constexpr std::size_t kFewPoints = 16;
  struct Facet {
    meshing::FacetIndex index;
    meshing::FeatureSlot slot;
  };

  template <class Refinement>
  void AddSizes(const Delta& delta, Refinement& refinement) {
    for (const plc::SizeFeature<D>& f : delta.added_sizes) {
      sizes_[f.id] = refinement.AddSizing(RegionOf(f));
    }
  }
  // Points, segments, facets.
  template <class Refinement>
  void AddOthers(const Delta& delta, Refinement& refinement, Steps& steps) {
    AddPoints(delta, refinement, steps);
    AddSegments(delta, refinement, steps);
    AddFacets(delta, refinement, steps);
    if (!steps.stopped()) UpdateSurfaces(delta, refinement);
  }

  template <class Refinement>
  void RemoveSegments(const Delta& delta, Refinement& refinement) {
    for (const plc::SegmentFeature<D>& s : delta.removed_segments) {
      const auto index = segments_.Find(points_.at(s.p_id), points_.at(s.q_id));
      FreeSlot(segments_[index].slot);
      refinement.RemoveSegment(segments_[index].root);
      segments_.Remove(index);
      if constexpr (D == 2) {
        if (!s.polygons.empty()) toggled_walls_.push_back({s.p, s.q, s.polygons});
      }
    }
  }

  template <class Refinement>
  void RemoveFacets(const Delta& delta, Refinement& refinement) {
    // If an edit is undone, its facets are removed, and their corners may be removed, too.
    if (!new_facets_.empty()) {
      absl::flat_hash_set<meshing::FeatureSlot> gone;
      for (const plc::FacetFeature& f : delta.removed_facets) gone.insert(facets_.at(f.id).slot);
      std::erase_if(new_facets_, [&](const NewFacet& added) { return gone.contains(added.slot); });
    }
    for (const plc::FacetFeature& f : delta.removed_facets) {
      const auto it = facets_.find(f.id);
      refinement.RemoveFacet(it->second.index);
      const meshing::FeatureSlot slot = it->second.slot;
      gone_facets_.push_back(slot);
      FreeSlot(slot);
      facets_.erase(it);
    }
  }

  // Adds many points in an order that suits a triangulation that is filled meanwhile.
  template <class Refinement>
  void AddPoints(const Delta& delta, Refinement& refinement, Steps& steps) {
    const auto add = [&](const plc::PointFeature<D>& p) {
      points_[p.id] = refinement.AddPoint(p.p, NewSlot(p.id));
    };
    if (delta.added_points.size() <= kFewPoints) {
      for (const plc::PointFeature<D>& p : delta.added_points) add(p);
      return;
    }
    points_.reserve(points_.size() + delta.added_points.size());
    segments_.Reserve(delta.added_segments.size());
    std::vector<Point> positions;
    positions.reserve(delta.added_points.size());
    for (const plc::PointFeature<D>& p : delta.added_points) positions.push_back(p.p);
    const std::vector<std::uint32_t> order = delaunay::InsertOrder(positions, steps);
    constexpr std::size_t kAhead = 8;  // prefetched so many steps ahead
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (steps.Stop()) return;
      if (i + 2 * kAhead < order.size()) {
        __builtin_prefetch(&delta.added_points[order[i + 2 * kAhead]]);
      }
      if (i + kAhead < order.size()) points_.prefetch(delta.added_points[order[i + kAhead]].id);
      add(delta.added_points[order[i]]);
    }
  }

  template <class Refinement>
  void AddSegments(const Delta& delta, Refinement& refinement, Steps& steps) {
    for (const plc::SegmentFeature<D>& s : delta.added_segments) {
      if (steps.Stop()) return;
      const bool forward = s.p < s.q;
      const meshing::FeatureSlot slot = NewSlot(s.id);
      segments_.Add(points_.at(forward ? s.p_id : s.q_id), points_.at(forward ? s.q_id : s.p_id),
                    slot);
      if constexpr (D == 2) {
        if (s.polygons.empty()) continue;
        walls_[slot] = s.polygons;
        toggled_walls_.push_back({s.p, s.q, s.polygons});
      }
    }
    segments_.Update([&](meshing::VertexIndex v) -> const Point& { return refinement.vertex(v).p; },
                     [&](auto* s) {
                       if (steps.Stop()) return;
                       if constexpr (requires { refinement.RemoveSegment(s->root); }) {
                         if (s->root != meshing::kNil) refinement.RemoveSegment(s->root);
                       }
                       s->root = refinement.AddSegment(s->ends[0], s->ends[1], s->slot, s->shape);
                     });
  }

  template <class Refinement>
  void AddFacets(const Delta& delta, Refinement& refinement, Steps& steps) {
    for (const plc::FacetFeature& f : delta.added_facets) {
      if (steps.Stop()) return;
      const meshing::FeatureSlot slot = NewSlot(f.id);
      NewFacet fresh = {slot, {}};
      std::vector<std::vector<meshing::VertexIndex>> rings;
      for (const auto& ring : f.rings) {
        rings.emplace_back();
        for (const FeatureId id : ring) rings.back().push_back(points_.at(id));
        fresh.corners.insert(fresh.corners.end(), rings.back().begin(), rings.back().end());
      }
      facets_[f.id] = {refinement.AddFacet(rings, slot), slot};
      new_facets_.push_back(std::move(fresh));
    }
  }

  // Call after all facets were removed and added.
  template <class Refinement>
  void UpdateSurfaces(const Delta& delta, const Refinement& refinement) {
    if constexpr (D == 3) {
      const auto toggle = [&](const plc::FacetFeature& f) {
        const auto owners = surfaces_.SurfacesOf(f.id);
        if (!owners.empty())
          toggled_walls_.push_back({f.positions, {owners.begin(), owners.end()}});
      };
      for (const plc::FacetFeature& f : delta.removed_facets) toggle(f);
      const auto& changes =
          surfaces_.Update(delta.removed_facets, delta.added_facets,
                           [&](FeatureId id) { return refinement.vertex(points_.at(id)).p; });
      for (const plc::FacetFeature& f : delta.added_facets) toggle(f);
      for (const SurfaceTable::Change& change : changes) {
        const Facet& facet = facets_.at(change.polygon);
        if (!Counts(RegionTerm::kOthersFollow)) continue;
        resurfaced_facets_.push_back(facet.slot);
        std::vector<FeatureId> owners;
        std::set_symmetric_difference(change.before.begin(), change.before.end(),
                                      change.after.begin(), change.after.end(),
                                      std::back_inserter(owners));
        toggled_walls_.push_back(
            {refinement.complex().facets[facet.index].rings(), std::move(owners)});
      }
    }
  }

  static meshing::SizingRegion<D> RegionOf(const plc::SizeFeature<D>& f) {
    const Sizing& s = f.sizing;
    if constexpr (D == 2) {
      if (s.shape == SizeShape::kPolygon) {
        const auto area = std::make_shared<const meshing::PolygonArea>(f.positions);
        return {area->lo(), area->hi(), 0, s.target, area};
      }
    }
    if (s.shape == SizeShape::kCapsule) {
      std::vector<Point> vertices;
      for (const auto& vertex : s.path) vertices.push_back(plc::CornerOf<D>(vertex));
      const auto line = std::make_shared<const meshing::Polyline<D>>(vertices);
      return {line->lo(), line->hi(), s.radius, s.target, line};
    }
    Point hi = f.at;
    if (s.shape == SizeShape::kBox) {
      for (int k = 0; k < D; ++k) hi[k] = s.hi[k];
    }
    return {f.at, hi, s.shape == SizeShape::kDisc ? s.radius : 0, s.target, nullptr};
  }
  meshing::FeatureSlot NewSlot(FeatureId id) {
    if (free_.empty()) {
      ids_.push_back(id);
      return static_cast<meshing::FeatureSlot>(ids_.size() - 1);
    }
    const meshing::FeatureSlot slot = free_.back();
    free_.pop_back();
    ids_[slot] = id;
    return slot;
  }
  void FreeSlot(meshing::FeatureSlot slot) { freed_.push_back(slot); }

  LargeVector<FeatureId> ids_;  // by slot
  std::vector<meshing::FeatureSlot> free_, freed_;
  absl::flat_hash_map<FeatureId, meshing::VertexIndex> points_;
  absl::flat_hash_map<FeatureId, typename meshing::SizingField<D>::Index> sizes_;
  WedgeTable<D> segments_;
  absl::flat_hash_map<FeatureId, Facet> facets_;
  absl::flat_hash_map<meshing::FeatureSlot, std::vector<FeatureId>> walls_;  // 2D
  SurfaceTable surfaces_;                                                    // 3D
  std::vector<Wall<D>> toggled_walls_;
  std::vector<NewFacet> new_facets_;
  std::vector<meshing::FeatureSlot> gone_facets_, resurfaced_facets_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_
