// The input as the mesher knows it: client ids on one side, vertices, subsegments and
// small slots on the other. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_

#include <memory>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/huge_pages.h"
#include "core/dynamic_mesh/wedge_table.h"
#include "core/mesh/delaunay_insert_order.h"
#include "core/meshing/elements.h"
#include "core/meshing/sizing_field.h"
#include "core/plc/delta.h"
#include "dynmesh/feature.h"

namespace dynmesh {

class FeatureTable {
 public:
  // Slot 0 is the domain box.
  FeatureTable() : ids_{kBoxFeature} {}

  FeatureId IdOf(meshing::FeatureSlot slot) const {
    return slot == meshing::kNil ? kNoFeature : ids_[slot];
  }

  // For so few, finding an order costs more than it saves.
  static constexpr std::size_t kFewPoints = 16;

  // Hands a change of input to the refinement. Many points go in an order that suits
  // a triangulation that grows along.
  template <class Refinement>
  void Apply(const plc::Delta<2>& delta, Refinement& refinement) {
    for (const plc::SizeFeature<2>& f : delta.removed_sizes) {
      const auto it = sizes_.find(f.id);
      refinement.RemoveSizing(it->second);
      sizes_.erase(it);
    }
    for (const plc::SizeFeature<2>& f : delta.added_sizes) {
      sizes_[f.id] = refinement.AddSizing(RegionOf(f));
    }
    for (const plc::SegmentFeature<2>& s : delta.removed_segments) {
      const WedgeTable::Index index = segments_.Find(points_.at(s.p_id), points_.at(s.q_id));
      FreeSlot(segments_[index].slot);
      refinement.RemoveSegment(segments_[index].root);
      segments_.Remove(index);
      if (!s.polygons.empty()) toggled_walls_.push_back({s.p, s.q, s.polygons});
    }
    for (const plc::PointFeature<2>& p : delta.removed_points) {
      const auto it = points_.find(p.id);
      FreeSlot(refinement.vertex(it->second).feature);
      refinement.RemovePoint(it->second);
      points_.erase(it);
    }
    const auto add = [&](const plc::PointFeature<2>& p) {
      points_[p.id] = refinement.AddPoint(p.p, NewSlot(p.id));
    };
    if (delta.added_points.size() <= kFewPoints) {
      for (const plc::PointFeature<2>& p : delta.added_points) add(p);
    } else {
      points_.reserve(points_.size() + delta.added_points.size());
      segments_.Reserve(delta.added_segments.size());
      std::vector<geometry::Point2> positions;
      positions.reserve(delta.added_points.size());
      for (const plc::PointFeature<2>& p : delta.added_points) positions.push_back(p.p);
      const std::vector<std::uint32_t> order = mesh::InsertOrder(positions);
      constexpr std::size_t kAhead = 8;  // asked of memory so much before it is wanted
      for (std::size_t i = 0; i < order.size(); ++i) {
        if (i + 2 * kAhead < order.size()) {
          __builtin_prefetch(&delta.added_points[order[i + 2 * kAhead]]);
        }
        if (i + kAhead < order.size()) points_.prefetch(delta.added_points[order[i + kAhead]].id);
        add(delta.added_points[order[i]]);
      }
    }
    for (const plc::SegmentFeature<2>& s : delta.added_segments) {
      const bool forward = s.p < s.q;
      const meshing::FeatureSlot slot = NewSlot(s.id);
      segments_.Add(points_.at(forward ? s.p_id : s.q_id), points_.at(forward ? s.q_id : s.p_id),
                    slot);
      if (s.polygons.empty()) continue;
      walls_[slot] = s.polygons;
      toggled_walls_.push_back({s.p, s.q, s.polygons});
    }
    segments_.Update([&](meshing::VertexIndex v) { return refinement.vertex(v).p; },
                     [&](WedgeTable::Segment* s) {
                       if (s->root != meshing::kNil) refinement.RemoveSegment(s->root);
                       s->root = refinement.AddSegment(s->ends[0], s->ends[1], s->slot, s->shape);
                     });
  }

  // An edge of polygons that came or went since Collect. Of one that only changed owner or
  // polygons, what went and what came.
  struct Wall {
    geometry::Point2 p, q;
    std::vector<FeatureId> polygons;  // ascending
  };
  const std::vector<Wall>& toggled_walls() const { return toggled_walls_; }
  // The polygons that have an edge where the segment in that slot lies, ascending.
  std::span<const FeatureId> PolygonsOf(meshing::FeatureSlot slot) const {
    if (walls_.empty()) return {};
    const auto it = walls_.find(slot);
    return it == walls_.end() ? std::span<const FeatureId>() : it->second;
  }

  // Slots of removed features keep their ids until here.
  void Collect() {
    if (!walls_.empty()) {
      for (const meshing::FeatureSlot slot : freed_) walls_.erase(slot);
    }
    toggled_walls_.clear();
    free_.insert(free_.end(), freed_.begin(), freed_.end());
    freed_.clear();
  }

  std::size_t bytes() const {
    return points_.capacity() * 17 + ids_.capacity() * sizeof(FeatureId) + segments_.bytes();
  }

 private:
  static meshing::SizingRegion<2> RegionOf(const plc::SizeFeature<2>& f) {
    const Sizing& s = f.sizing;
    if (s.shape == SizeShape::kPolygon) {
      const auto area = std::make_shared<const meshing::PolygonArea>(f.places);
      return {area->lo(), area->hi(), 0, s.target, area};
    }
    const geometry::Point2 hi =
        s.shape == SizeShape::kBox ? geometry::Point2{{s.hi[0], s.hi[1]}} : f.at;
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
  absl::flat_hash_map<FeatureId, meshing::SizingField<2>::Index> sizes_;
  WedgeTable segments_;
  absl::flat_hash_map<meshing::FeatureSlot, std::vector<FeatureId>> walls_;
  std::vector<Wall> toggled_walls_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_
