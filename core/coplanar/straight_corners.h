// Corners that rings go straight through.
#ifndef DYNMESH_CORE_COPLANAR_STRAIGHT_CORNERS_H_
#define DYNMESH_CORE_COPLANAR_STRAIGHT_CORNERS_H_

#include <functional>
#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

// Removes a corner from all its rings if each goes straight through it, between the same two
// corners, and it is not `kept`. Each ring keeps at least three corners. Exact. REQUIRES:
// `positions` are in lexicographic order. O(corners) expected. With `within`, corners that are no
// farther from the line than that are on it, those that were dropped before, too.
void DropStraightCorners(const std::vector<geometry::Point3>& positions,
                         const std::vector<bool>& kept, std::vector<FaceRings>& faces,
                         const std::function<double(Corner)>& within = nullptr);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_STRAIGHT_CORNERS_H_
