// Corners that rings go straight through.
#ifndef DYNMESH_CORE_IO_STRAIGHT_CORNERS_H_
#define DYNMESH_CORE_IO_STRAIGHT_CORNERS_H_

#include <vector>

#include "core/geometry/point.h"
#include "core/io/coplanar_regions.h"

namespace dynmesh::io {

// Removes a corner from all its rings if each goes straight through it, between the same two
// corners, and it is not `kept`. Each ring keeps at least three corners. Exact. REQUIRES: `places`
// are in lexicographic order. O(corners) expected.
void DropStraightCorners(const std::vector<geometry::Point3>& places, const std::vector<bool>& kept,
                         std::vector<FaceRings>& faces);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_STRAIGHT_CORNERS_H_
