// Corners that rings go straight through.
#ifndef DYNMESH_CORE_IO_STRAIGHT_CORNERS_H_
#define DYNMESH_CORE_IO_STRAIGHT_CORNERS_H_

#include <vector>

#include "core/geometry/point.h"
#include "core/io/coplanar_regions.h"

namespace dynmesh::io {

// Takes a corner out of all rings that have it if each goes straight through it, from the same
// corner to the same corner, and it is not `kept`. Three corners stay of each ring. Exact.
// `places` in lexicographic order. O(corners) expected.
void DropStraightCorners(const std::vector<geometry::Point3>& places, const std::vector<bool>& kept,
                         std::vector<FaceRings>& faces);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_STRAIGHT_CORNERS_H_
