// Cuts a face that is not flat into triangles between its corners. Pure, thread-safe.
#ifndef DYNMESH_CORE_COPLANAR_CUT_FACE_H_
#define DYNMESH_CORE_COPLANAR_CUT_FACE_H_

#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

// Ears with the largest least angle are cut first, as seen along the face's mean normal. A function
// of coordinates. Empty for a ring of more than 200 corners, or without an area. O(corners^3).
std::vector<CornerRing> CutFace(const std::vector<geometry::Point3>& positions,
                                const CornerRing& ring);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_CUT_FACE_H_
