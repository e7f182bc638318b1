// Thins a surface where a distance leaves room for it (client/cleaning/feature_edges.h), so that a
// mesh of it does not follow triangles that are finer than that.
#ifndef DYNMESH_CLIENT_PREPARATION_THINNING_H_
#define DYNMESH_CLIENT_PREPARATION_THINNING_H_

#include <cstddef>

#include "core/io/formats/geometry.h"

namespace dynmesh::preparation {

// In degrees. Sharper edges stay edges, and corners of theirs that turn by more stay corners.
inline constexpr double kThinningAngle = 20;

struct ThinningCounts {
  std::size_t dropped = 0;            // corners; if none, nothing has changed
  std::size_t before = 0, after = 0;  // triangles
};

// Drops corners of faces, so that each point of the new faces is within `within` of the old ones,
// and the other way round. Faces become polygons of one ring each, triangles where they change;
// they keep markers and names, and edges between different ones. What does not meet is `tolerance`
// apart, if it was. REQUIRES: a mesh accepts the geometry; both lengths are positive. Expected O(n
// lg n).
ThinningCounts DropCorners(double within, double tolerance, io::Geometry& geometry);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_THINNING_H_
