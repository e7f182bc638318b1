// Target lengths (dynmesh/feature.h, Sizing) that keep simplices below an area or a volume. Pure.
//
// No edge at a sizing region is longer than sqrt(2) times its target h. So no triangle there is
// larger than the equilateral one of that side, sqrt(3)/2 h^2, and no tetrahedron than the regular
// one, h^3 / 3.
#ifndef DYNMESH_CLIENT_CLI_SIZES_OF_LIMITS_H_
#define DYNMESH_CLIENT_CLI_SIZES_OF_LIMITS_H_

#include <array>
#include <cmath>
#include <cstddef>

#include "core/transfer/simplex.h"

namespace dynmesh::cli {

// Rounding must not make a simplex that is above the limit by a last bit.
inline constexpr double kBelowLimit = 1 - 0x1p-40;

inline double TargetOfArea(double area) {
  return kBelowLimit * std::sqrt(area / (std::sqrt(3.0) / 2));
}
inline double TargetOfVolume(double volume) { return kBelowLimit * std::cbrt(3 * volume); }

// The ball that touches the sides of a tetrahedron. Its radius is 0 if the tetrahedron is flat, and
// it is at a corner if that lies on a line.
struct InscribedBall {
  std::array<double, 3> centre;
  double radius;
};
inline InscribedBall InscribedBallOf(const transfer::Corners<3>& p) {
  using transfer::operator-;
  using transfer::Cross;
  InscribedBall ball = {{0, 0, 0}, 0};
  double areas = 0;  // twice those of the sides
  for (std::size_t k = 0; k < 4; ++k) {
    const transfer::Vec<3>& q = p[(k + 1) % 4];
    const transfer::Vec<3> n = Cross(p[(k + 2) % 4] - q, p[(k + 3) % 4] - q);
    const double area = std::hypot(n[0], n[1], n[2]);
    areas += area;
    for (std::size_t d = 0; d < 3; ++d) ball.centre[d] += area * p[k][d];
  }
  if (areas == 0) return {p[0], 0};
  for (double& c : ball.centre) c /= areas;
  ball.radius = std::abs(transfer::ScaledMeasure(p)) / areas;
  return ball;
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_SIZES_OF_LIMITS_H_
