// Corners that rings go straight through.
#ifndef DYNMESH_CORE_COPLANAR_STRAIGHT_CORNERS_H_
#define DYNMESH_CORE_COPLANAR_STRAIGHT_CORNERS_H_

#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

// Removes a corner from all its rings if each goes straight through it, between the same two
// corners, and it is not `kept`. Each ring keeps at least three corners. Exact. REQUIRES:
// `positions` are in lexicographic order. O(corners) expected.
void DropStraightCorners(const std::vector<geometry::Point3>& positions,
                         const std::vector<bool>& kept, std::vector<FaceRings>& faces);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_STRAIGHT_CORNERS_H_
