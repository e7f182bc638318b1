// The closed surfaces that polygons of space make up (mesh.h, RegionId): which polygon is part of
// which.
//
// Polygons are joined where they share an edge, by the ids of its ends. Those that fall apart have
// no sides to speak of and do not count; those with an edge of their own are peeled off, again and
// again. What is left falls into pieces joined by edges. One with two
// polygons at each of its edges is a closed surface, wherever it is; in others it matters who is
// next to whom around an edge (chambers.h). A function of the set of polygons.
//
// Thread-compatible. A change costs O(k lg k) expected, k the edges of all polygons that hang
// together with one that comes, goes, gets other rings, or moves and has more than two polygons at
// some edge of its piece, or falls apart by that or no longer; for others that only move O(1), or
// of several rings O(k lg^2 k) for k corners.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_SURFACE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_SURFACE_TABLE_H_

#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "absl/functional/function_ref.h"
#include "core/dynamic_mesh/chambers.h"
#include "core/geometry/point.h"
#include "core/plc/delta.h"
#include "dynmesh/feature.h"

namespace dynmesh {

class SurfaceTable {
 public:
  // A polygon whose surfaces are others than before.
  struct Change {
    FeatureId polygon;
    SurfaceIds before, after;
    friend bool operator==(const Change&, const Change&) = default;
  };
  // Both sorted by id, as in a Delta; `place_of`: where corners are by now. Returns the changes of
  // polygons that were there before and stayed where they are, by id, valid until the next call.
  const std::vector<Change>& Update(std::span<const plc::FacetFeature> removed,
                                    std::span<const plc::FacetFeature> added,
                                    absl::FunctionRef<geometry::Point3(FeatureId)> place_of);

  // The surfaces that a polygon is part of, by their ids, ascending: at most two.
  std::span<const FeatureId> SurfacesOf(FeatureId polygon) const {
    const auto it = polygons_.find(polygon);
    if (it == polygons_.end()) return {};
    return it->second.surfaces;
  }

 private:
  struct Polygon {
    Rings rings;
    SurfaceIds surfaces;
    bool is_crowded = false;  // some edge of its piece has more than two polygons
    bool is_apart = false;    // plc::FallsApart
  };
  using Neighbours = absl::InlinedVector<FeatureId, 2>;

  void Remove(const plc::FacetFeature& polygon);
  void Add(const plc::FacetFeature& polygon);
  void CollectTouched();
  void Peel();
  void FindPieces(absl::FunctionRef<geometry::Point3(FeatureId)> place_of);

  absl::flat_hash_map<FeatureId, Polygon> polygons_;
  absl::flat_hash_map<plc::EdgeKey, Neighbours> edges_;  // the polygons at each

  // Of the update under way.
  std::vector<plc::EdgeKey> seeds_;  // edges that gained or lost a polygon
  struct Touched {
    bool peeled = false;
    bool reached = false;
    bool is_crowded = false;
    SurfaceIds surfaces;
  };
  absl::flat_hash_map<FeatureId, Touched> touched_;
  std::vector<FeatureId> stack_;
  std::vector<Change> changes_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_SURFACE_TABLE_H_
