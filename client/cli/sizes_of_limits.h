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

#include "core/io/elements/element_mesh.h"

namespace dynmesh::cli {

// Rounding must not make a simplex that is above the limit by a last bit.
inline constexpr double kBelowLimit = 1 - 0x1p-40;

inline double TargetOfArea(double area) {
  return kBelowLimit * std::sqrt(area / (std::sqrt(3.0) / 2));
}
inline double TargetOfVolume(double volume) { return kBelowLimit * std::cbrt(3 * volume); }

// The ball that touches the sides of tetrahedron i. Its radius is 0 if the tetrahedron is flat.
struct InscribedBall {
  std::array<double, 3> centre;
  double radius;
};
inline InscribedBall InscribedBallOf(const io::ElementMesh& mesh, std::size_t i) {
  using Vec = std::array<double, 3>;
  std::array<Vec, 4> p;
  for (std::size_t k = 0; k < 4; ++k) p[k] = mesh.positions[mesh.tetrahedra[i].corners[k]];
  const auto minus = [](const Vec& a, const Vec& b) {
    return Vec{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  };
  const auto cross = [](const Vec& a, const Vec& b) {
    return Vec{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  InscribedBall ball = {{0, 0, 0}, 0};
  double areas = 0;  // twice those of the sides
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec n =
        cross(minus(p[(k + 2) % 4], p[(k + 1) % 4]), minus(p[(k + 3) % 4], p[(k + 1) % 4]));
    const double area = std::hypot(n[0], n[1], n[2]);
    areas += area;
    for (std::size_t d = 0; d < 3; ++d) ball.centre[d] += area * p[k][d];
  }
  for (double& c : ball.centre) c /= areas;
  const Vec u = minus(p[1], p[0]), n = cross(minus(p[2], p[0]), minus(p[3], p[0]));
  ball.radius = std::abs(u[0] * n[0] + u[1] * n[1] + u[2] * n[2]) / areas;
  return ball;
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_SIZES_OF_LIMITS_H_
