// Moves corners of nearly flat patches until each patch is as flat as doubles allow.
//
// Corners move least, in units of their roundings (least squares), such that each patch has its
// corners in one plane: the planes are found with the corners. What need not move does not:
//
//   * Patches that are exactly flat keep their planes, and those that are within the rounding of a
//     plane of one coordinate get that plane, exactly. Where their neighbours cannot be flat then,
//     their planes move as others.
//   * Corners of patches that are flat already stay, if no neighbour needs them to move.
//
// Where no places are on all planes, the patches that are farthest off stay as they are.
//
// A function of coordinates if patches and corners are numbered by them. Pure, thread-safe.
// O(corners) for a step of conjugate gradients; their number is bounded.
#ifndef DYNMESH_CORE_COPLANAR_FLATTEN_H_
#define DYNMESH_CORE_COPLANAR_FLATTEN_H_

#include <cstddef>
#include <vector>

#include "core/coplanar/coplanar_regions.h"
#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

// A corner moves by no more than so many roundings of each coordinate.
inline constexpr double kMostRoundings = 4;

// Moves `positions`, and returns the patches that cannot be flat with the others, or whose corners
// would have to move farther, ascending. If there are some, nothing has moved. `roundings` are of
// the positions.
std::vector<std::size_t> Flatten(const std::vector<FaceRings>& patches,
                                 const std::vector<geometry::Vector3>& roundings,
                                 std::vector<geometry::Point3>& positions);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_FLATTEN_H_
