// The chambers of a mesh: the parts that its features divide it into. Two simplices are in one
// chamber iff a path leads from one to the other through sides that are no subsegment (in 3D: no
// subfacet) of a feature. So a closed outline has its inside as a chamber, whether or not a polygon
// feature says so.
//
// Pure functions, thread-safe. Chambers are numbered in the order of their first simplices.
#ifndef DYNMESH_CORE_MESH_DATA_CHAMBERS_H_
#define DYNMESH_CORE_MESH_DATA_CHAMBERS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dynmesh/mesh.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::mesh_data {

struct Chambers {
  std::vector<std::uint32_t> of;  // of each simplex, in the order of rows
  std::vector<Slot> corners;      // of each simplex: the rows of its vertices
  // Of each chamber. Outside: it has a side of the mesh's border. Hole: it is in no polygon, and
  // only edges of polygons lie between it and others, no segments; 2D only.
  std::vector<bool> is_outside, is_hole;
  std::size_t count() const { return is_outside.size(); }
};

// Of a whole mesh: the domain's border is its border. O(mesh) expected. REQUIRES: columns agree,
// and corners and ends are vertices of the mesh.
Chambers FindChambers(const Mesh& mesh);

// Where a position lies.
struct PlaceInChambers {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::uint32_t chamber = kNone;  // kNone: outside of the mesh
  bool is_between = false;        // on a side between this chamber and another one
  friend bool operator==(const PlaceInChambers&, const PlaceInChambers&) = default;
};

// Exact, for each of `positions` (in 2D the third coordinate is not used). O((simplices + hits) lg
// positions).
// REQUIRES: `chambers` is FindChambers(mesh).
std::vector<PlaceInChambers> LocateInChambers(const Mesh& mesh, const Chambers& chambers,
                                              std::span<const std::array<double, 3>> positions);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_CHAMBERS_H_
