// Polygons of a surface as triangles. Pure, thread-safe.
#ifndef DYNMESH_CLIENT_CLEANING_SURFACE_POLYGONS_H_
#define DYNMESH_CLIENT_CLEANING_SURFACE_POLYGONS_H_

#include <array>
#include <vector>

#include "client/cleaning/node_table.h"
#include "client/cleaning/polygon_rings.h"
#include "client/cleaning/surface.h"

namespace dynmesh::cleaning {

struct PolygonPieces {
  std::vector<std::array<Node, 3>> triangles;  // oriented as the first ring
  // A triangulation of its inside without further nodes: all corners are within `flat` of a plane,
  // and edges meet in corners only. Else the triangles cover places of even-odd inside once modulo
  // 2.
  bool is_regular = false;
  bool is_flat = false;
};

// The even-odd inside of rings. Repeated neighbours in a ring are taken once, edges that the rings
// have an even number of times are left out. A function of the rings' coordinates as chains, except
// for the orientation of triangles. O(n lg n) expected for n corners in a plane.
PolygonPieces PiecesOf(const Surface& surface, const std::vector<NodeRing>& rings, double flat);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_SURFACE_POLYGONS_H_
