// Target lengths (dynmesh/feature.h, Sizing) that keep simplices below an area or a volume. Pure.
//
// No edge at a sizing region is longer than sqrt(2) times its target h. So no triangle there is
// larger than the equilateral one of that side, sqrt(3)/2 h^2, and no tetrahedron than the regular
// one, h^3 / 3.
#ifndef DYNMESH_CLIENT_CLI_SIZES_OF_LIMITS_H_
#define DYNMESH_CLIENT_CLI_SIZES_OF_LIMITS_H_

#include <cmath>

namespace dynmesh::cli {

// Rounding must not make a simplex that is above the limit by a last bit.
inline constexpr double kBelowLimit = 1 - 0x1p-40;

inline double TargetOfArea(double area) {
  return kBelowLimit * std::sqrt(area / (std::sqrt(3.0) / 2));
}
inline double TargetOfVolume(double volume) { return kBelowLimit * std::cbrt(3 * volume); }

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_SIZES_OF_LIMITS_H_
