// How far the edges of one set of 2D features, or the faces of one set of 3D features, are from
// those of another one. For all their points, not for samples.
//
// A distance to one edge or face is a convex function. So a part of another one is within D if its
// ends, or corners, are within D of the same edge or face; else it is cut, and both parts are
// looked at (client/cleaning/patch_distance.h). Edges and faces that both sets have are skipped.
//
// Pure, thread-safe. O(n lg n) for n edges or faces if few of them differ.
#ifndef DYNMESH_CLIENT_PREPARATION_FARTHEST_H_
#define DYNMESH_CLIENT_PREPARATION_FARTHEST_H_

#include <optional>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::preparation {

// A bound of the distance from each point of an edge or face of `from` to the nearest one of `to`:
// `least` times a power of 2, or `most`, and nothing if it is more. "Nothing" may be wrong where
// distances are nearly `most`. Edges are segments and those of polygons; faces are polygons.
// REQUIRES: 0 < least <= most; ends and corners are points of their set.
std::optional<double> FarthestBound(const std::vector<Feature>& from,
                                    const std::vector<Feature>& to, int dimension, double least,
                                    double most);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_FARTHEST_H_
