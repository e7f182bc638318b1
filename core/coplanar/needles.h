// Faces without area: all corners on one line, exactly or within a distance.
//
// Such a face closes a gap between faces of which one has an edge where the others have several.
// Without it, the long edge gets the corners that stand on it, and the gap stays closed.
#ifndef DYNMESH_CORE_COPLANAR_NEEDLES_H_
#define DYNMESH_CORE_COPLANAR_NEEDLES_H_

#include <cstddef>
#include <functional>
#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

// Empties the rings without area and returns their number. `within` is how far a corner may be from
// the line; 0: exactly on it. A ring stays if a segment lies on its long edge, if that edge is of a
// ring with the same corners, or if it has more than 16 corners. `segments` are ascending. Each
// ring is a face. The result does not depend on the order of rings, if it does not on that of their
// corners. Expected O(n lg n) for n corners.
std::size_t DropNeedles(const std::vector<geometry::Point3>& positions,
                        const std::function<double(Corner)>& within,
                        const std::vector<CornerPair>& segments, std::vector<CornerRing>& rings);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_NEEDLES_H_
