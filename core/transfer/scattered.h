// Values at positions from values at other positions: linear in each simplex of the Delaunay
// triangulation of the sources.
//
// Exact for linear fields inside the hull of the sources, but for rounding and a skin of 10^-6 of
// the extent; never outside the range of the values. Beyond the hull values stay near those of the
// hull, and run on to those of the sources nearest to the corners of a far box. A function of
// the positions and values alone. Pure, thread-safe.
#ifndef DYNMESH_CORE_TRANSFER_SCATTERED_H_
#define DYNMESH_CORE_TRANSFER_SCATTERED_H_

#include <span>
#include <vector>

namespace dynmesh::transfer {

// `sources`: n positions of `dimension` (2 or 3) coordinates, all distinct. `values`: k for each.
// Returns k for each of `targets`, positions as well. Coordinates are finite and below 2^100 in
// magnitude. O((n + targets) lg n) expected. REQUIRES: n > 0.
std::vector<double> InterpolateScattered(int dimension, std::span<const double> sources,
                                         std::span<const double> values,
                                         std::span<const double> targets);

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_SCATTERED_H_
