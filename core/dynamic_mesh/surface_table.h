// The closed surfaces that polygons of space make up (mesh.h, RegionId): which polygon is part of
// which.
//
// Polygons are joined where they share an edge, by the ids of its ends: places do not matter here.
// Those with an edge of their own are peeled off, again and again. What is left falls into pieces
// joined by edges; a piece is a closed surface if an even number of its polygons meet at each of
// its edges, and goes by the least id of its polygons. A function of the set of polygons.
//
// Thread-compatible. A change costs O(k) expected, k the edges of all polygons that hang together
// with one that comes, goes or gets other rings; O(1) for one that only moves.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_SURFACE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_SURFACE_TABLE_H_

#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "core/plc/delta.h"
#include "dynmesh/feature.h"

namespace dynmesh {

class SurfaceTable {
 public:
  // A polygon whose surface is another than before; kNoFeature is none.
  struct Change {
    FeatureId polygon;
    FeatureId before;
    FeatureId after;
    friend bool operator==(const Change&, const Change&) = default;
  };
  // Both sorted by id, as in a Delta. Returns the changes of polygons that were there before and
  // still are, by id, valid until the next call.
  const std::vector<Change>& Update(std::span<const plc::FacetFeature> removed,
                                    std::span<const plc::FacetFeature> added);

  // The id of the surface that a polygon is part of: none, or one.
  std::span<const FeatureId> SurfaceOf(FeatureId polygon) const {
    const auto it = polygons_.find(polygon);
    if (it == polygons_.end() || it->second.surface == kNoFeature) return {};
    return {&it->second.surface, 1};
  }

 private:
  struct Polygon {
    std::vector<plc::EdgeKey> edges;
    FeatureId surface = kNoFeature;
  };
  using Neighbours = absl::InlinedVector<FeatureId, 2>;

  void Remove(const plc::FacetFeature& polygon);
  void Add(const plc::FacetFeature& polygon);
  void CollectTouched();
  void Peel();
  void FindSurfaces();

  absl::flat_hash_map<FeatureId, Polygon> polygons_;
  absl::flat_hash_map<plc::EdgeKey, Neighbours> edges_;  // the polygons at each

  // Of the update under way.
  std::vector<plc::EdgeKey> seeds_;  // edges that gained or lost a polygon
  struct Touched {
    bool peeled = false;
    bool reached = false;
    FeatureId surface = kNoFeature;
  };
  absl::flat_hash_map<FeatureId, Touched> touched_;
  std::vector<FeatureId> stack_;
  std::vector<Change> changes_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_SURFACE_TABLE_H_
