// The closed surfaces of polygons in 3D (mesh.h, RegionId): which polygon is part of which.
//
// Polygons are joined where they share an edge, by the ids of its ends. Polygons that fall apart do
// not count, since they have no two sides. Polygons with an edge that no other has are removed
// repeatedly. The rest falls into components joined by edges. A component with two polygons at each
// edge is one closed surface, wherever it is. In other components the order of polygons around an
// edge decides (chambers.h). A function of the set of polygons.
//
// Thread-compatible. Let k be the number of edges of all polygons connected with a changed one.
// Expected cost of an added, removed or changed polygon:
//   * O(k lg k) if it is added, removed or gets other rings;
//   * O(k lg k) if it moves and an edge of its component has more than two polygons, or it starts
//     or stops to fall apart by the move;
//   * O(1) if it moves otherwise; with several rings O(c lg^2 c) for its c corners.
#ifndef DYNMESH_CORE_REGIONS_SURFACE_TABLE_H_
#define DYNMESH_CORE_REGIONS_SURFACE_TABLE_H_

#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "absl/functional/function_ref.h"
#include "core/geometry/point.h"
#include "core/plc/delta.h"
#include "core/regions/chambers.h"
#include "dynmesh/feature.h"

namespace dynmesh {

class SurfaceTable {
 public:
  // A polygon with other surfaces than before.
  struct Change {
    FeatureId polygon;
    SurfaceIds before, after;
    friend bool operator==(const Change&, const Change&) = default;
  };
  // REQUIRES: both are sorted by id, as in a Delta. `position_of` returns the present position of a
  // corner. Returns the changes of polygons that were present and did not move, by id, valid until
  // the next call.
  const std::vector<Change>& Update(std::span<const plc::FacetFeature> removed,
                                    std::span<const plc::FacetFeature> added,
                                    absl::FunctionRef<geometry::Point3(FeatureId)> position_of);

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
    bool is_crowded = false;  // some edge of its component has more than two polygons
    bool is_apart = false;    // plc::FallsApart
  };
  using Neighbours = absl::InlinedVector<FeatureId, 2>;

  void Remove(const plc::FacetFeature& polygon);
  void Add(const plc::FacetFeature& polygon);
  void CollectTouched();
  void Peel();
  void FindComponents(absl::FunctionRef<geometry::Point3(FeatureId)> position_of);

  absl::flat_hash_map<FeatureId, Polygon> polygons_;
  absl::flat_hash_map<plc::EdgeKey, Neighbours> edges_;  // the polygons at each edge

  // Of the current update.
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

#endif  // DYNMESH_CORE_REGIONS_SURFACE_TABLE_H_
