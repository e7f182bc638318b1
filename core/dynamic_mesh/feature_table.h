// Maps the client's feature ids to the mesher's vertices, subsegments and small slots.
// Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_FEATURE_TABLE_H_

#include <cstddef>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/large_vector.h"
#include "core/base/steps.h"
#include "core/dynamic_mesh/wedge_table.h"
#include "core/meshing/elements.h"
#include "core/meshing/input_sink.h"
#include "core/plc/delta.h"
#include "core/regions/surface_table.h"
#include "core/regions/wall.h"
#include "dynmesh/feature.h"

namespace dynmesh {

template <int D>
class FeatureTable {
 public:
  using Point = geometry::Point<D>;
  using Delta = plc::Delta<D>;
  using Sink = meshing::InputSink<D>;
  using EditableSink = meshing::EditableSink<D>;

  // Slot 0 is the domain box.
  FeatureTable() : ids_{kBoxFeature} {}

  FeatureId IdOf(meshing::FeatureSlot slot) const {
    return slot == meshing::kNil ? kNoFeature : ids_[slot];
  }

  // Applies a change of input to the mesher. Removals first; a feature is removed before, and added
  // after, those that it depends on. If `steps` stop, table and mesher are unusable.
  void Apply(const Delta& delta, EditableSink& mesher, Steps& steps);
  void Apply(const Delta& delta, EditableSink& mesher) {
    AllSteps all;
    Apply(delta, mesher, all);
  }
  // The same for a change that only adds. REQUIRES: it is the first one.
  void Add(const Delta& delta, Sink& mesher, Steps& steps);

  // True if all of sizing feature f, which comes or goes with `delta`, certainly lies in one that
  // stays and is at least as fine. `present`: those before it.
  bool IsIdle(const plc::SizeFeature<D>& f, const Delta& delta,
              const meshing::SizingField<D>& present) const;

  // Walls added or removed since Collect. A wall that only changed owners counts as removed and
  // added.
  const std::vector<Wall<D>>& toggled_walls() const { return toggled_walls_; }
  // The owners of the wall in that slot, ascending: the polygons (2D) or closed surfaces (3D) that
  // lie on one side of it. 2D: the polygons with an edge on the segment. 3D: the surfaces that the
  // facet is part of.
  std::span<const FeatureId> OwnersOfWall(meshing::FeatureSlot slot) const;

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
  void Collect();

  // Call it first if features come once and never change: what only changes ask for is not kept.
  void SetFixed() { is_fixed_ = true; }

  std::size_t bytes() const;

 private:
  struct Facet {
    meshing::FacetIndex index;
    meshing::FeatureSlot slot;
  };

  void AddSizes(const Delta& delta, Sink& mesher);
  void AddOthers(const Delta& delta, Sink& mesher, EditableSink* editable, Steps& steps);
  void RemoveFacets(const Delta& delta, EditableSink& mesher);
  void RemoveSegments(const Delta& delta, EditableSink& mesher);
  void AddPoints(const Delta& delta, Sink& mesher, Steps& steps);
  void AddSegments(const Delta& delta, Sink& mesher, EditableSink* editable, Steps& steps);
  void AddFacets(const Delta& delta, Sink& mesher, Steps& steps);
  void UpdateSurfaces(const Delta& delta, const Sink& mesher);
  meshing::FeatureSlot NewSlot(FeatureId id);
  void FreeSlot(meshing::FeatureSlot slot) { freed_.push_back(slot); }

  bool is_fixed_ = false;
  LargeVector<FeatureId> ids_;  // by slot
  std::vector<meshing::FeatureSlot> free_, freed_;
  absl::flat_hash_map<FeatureId, meshing::VertexIndex>
      points_;  // fixed: only if something has ends
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
