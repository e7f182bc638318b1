// The polygons of a surface as triangles: those of more corners are cut as they are for cleaning.
#ifndef DYNMESH_CLIENT_PREPARATION_TRIANGLES_H_
#define DYNMESH_CLIENT_PREPARATION_TRIANGLES_H_

#include <vector>

#include "client/cleaning/patch_distance.h"
#include "dynmesh/feature.h"

namespace dynmesh::preparation {

struct PolygonPart {
  cleaning::TriangleCorners corners;
  FeatureId polygon = kNoFeature;
};

// In the order of the polygons; points at one place are one. Pure, thread-safe. REQUIRES: corners
// are points of `features`. O(n lg n).
std::vector<PolygonPart> TrianglesOf(const std::vector<Feature>& features);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_TRIANGLES_H_
