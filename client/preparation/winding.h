// Which places a surface winds around.
#ifndef DYNMESH_CLIENT_PREPARATION_WINDING_H_
#define DYNMESH_CLIENT_PREPARATION_WINDING_H_

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::preparation {

// The generalised winding number of the polygons around each place (A. Jacobson, L. Kavan and O.
// Sorkine, Robust inside-outside segmentation using generalized winding numbers, 2013): how often
// they go around it, counter-clockwise seen from outside; a fraction near holes. Nothing if two
// faces at an edge of two faces are oriented against each other: then numbers mean nothing. Points
// at one place are one. Pure, thread-safe. O(n) for each place and n faces.
std::optional<std::vector<double>> WindingNumbers(const std::vector<Feature>& features,
                                                  std::span<const std::array<double, 3>> places);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_WINDING_H_
