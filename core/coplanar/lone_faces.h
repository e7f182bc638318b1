// Which faces are surely in one plane with no neighbour: most of a curved surface.
#ifndef DYNMESH_CORE_COPLANAR_LONE_FACES_H_
#define DYNMESH_CORE_COPLANAR_LONE_FACES_H_

#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

// By face. Neighbours have an edge in common that no third face has. A face that may be within the
// rounding of a line is not lone. Faces may be empty. The order of corners does not matter.
// Expected O(corners). Pure, thread-safe.
std::vector<bool> LoneFaces(const std::vector<geometry::Point3>& positions,
                            const std::vector<geometry::Vector3>& roundings,
                            const std::vector<CornerRing>& faces);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_LONE_FACES_H_
