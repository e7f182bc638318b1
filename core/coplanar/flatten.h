// Moves corners of nearly flat patches until each patch is as flat as doubles allow.
//
// Each patch pulls its corners to its plane of least squares, in turn, until nothing moves: so
// corners move least, in units of their roundings. Patches that are exactly flat keep their planes,
// unless their neighbours cannot be flat then.
//
// A function of coordinates if patches and corners are numbered by them. Pure, thread-safe.
// O(corners) for a turn.
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

// Moves `positions`, and returns the patches that are not flat, or whose corners would have to move
// farther, ascending. If there are some, nothing has moved. `roundings` are of the positions.
std::vector<std::size_t> Flatten(const std::vector<FaceRings>& patches,
                                 const std::vector<geometry::Vector3>& roundings,
                                 std::vector<geometry::Point3>& positions);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_FLATTEN_H_
