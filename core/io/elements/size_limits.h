// Target lengths (dynmesh/feature.h, Sizing) that keep simplices below an area or a volume. Pure.
//
// No edge at a sizing region is longer than sqrt(2) times its target h. So no triangle there is
// larger than the equilateral one of that side, sqrt(3)/2 h^2, and no tetrahedron than the regular
// one, h^3 / 3.
#ifndef DYNMESH_CORE_IO_ELEMENTS_SIZE_LIMITS_H_
#define DYNMESH_CORE_IO_ELEMENTS_SIZE_LIMITS_H_

#include <array>
#include <cmath>
#include <cstddef>

namespace dynmesh::io {

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
inline InscribedBall InscribedBallOf(const std::array<std::array<double, 3>, 4>& p) {
  using Vector = std::array<double, 3>;
  const auto from = [](const Vector& a, const Vector& b) {
    return Vector{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  };
  const auto cross = [](const Vector& a, const Vector& b) {
    return Vector{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  InscribedBall ball = {{0, 0, 0}, 0};
  double areas = 0;  // twice those of the sides
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector& q = p[(k + 1) % 4];
    const Vector n = cross(from(q, p[(k + 2) % 4]), from(q, p[(k + 3) % 4]));
    const double area = std::hypot(n[0], n[1], n[2]);
    areas += area;
    for (std::size_t d = 0; d < 3; ++d) ball.centre[d] += area * p[k][d];
  }
  if (areas == 0) return {p[0], 0};
  for (double& c : ball.centre) c /= areas;
  const Vector u = from(p[0], p[1]), v = cross(from(p[0], p[2]), from(p[0], p[3]));
  ball.radius = std::abs(u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / areas;
  return ball;
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_ELEMENTS_SIZE_LIMITS_H_
