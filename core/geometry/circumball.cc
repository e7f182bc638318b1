#include "core/geometry/circumball.h"

#include <algorithm>
#include <utility>

#include "core/geometry/exact_vector.h"

namespace dynmesh::geometry {

Circumball CircumballOf(const Point3& p, const Point3& a, const Point3& b, const Point3& c) {
  std::array<const Point3*, 3> q = {&a, &b, &c};
  bool odd = false;
  const auto sort = [&](std::size_t i, std::size_t j) {
    if (!(*q[j] < *q[i])) return;
    std::swap(q[i], q[j]);
    odd = !odd;
  };
  sort(0, 1), sort(1, 2), sort(0, 1);
  std::array<Vector3, 3> d;
  std::array<double, 3> d2;
  for (std::size_t i = 0; i < 3; ++i) d[i] = Difference(q[i]->c, p.c), d2[i] = Dot(d[i], d[i]);
  const Circumball ball(d[0], d2[0], d[1], d2[1], d[2], d2[2], odd);
  if (ball.error <= 1e-9 * std::sqrt(std::min({d2[0], d2[1], d2[2]}))) return ball;
  return ExactCircumball(p, a, b, c);
}

// Computes the numerators and the determinant of the formula as integers, then divides once.
Circumball ExactCircumball(const Point3& p, const Point3& a, const Point3& b, const Point3& c) {
  Circumball ball;
  internal::Evaluate<3>({&p, &a, &b, &c}, [&](auto n, int exponent) {
    const internal::ExactCentre<n()> centre(p, a, b, c, exponent);
    const ScaledDouble det = ToScaledDouble(centre.det);
    if (det.mantissa == 0) return;
    for (std::size_t k = 0; k < 3; ++k) {
      const ScaledDouble sum = ToScaledDouble(centre.n[k]);
      ball.w[k] =
          std::ldexp(0.5 * sum.mantissa / det.mantissa, sum.exponent - det.exponent + exponent);
    }
    ball.r2 = Dot(ball.w, ball.w);
    ball.error = 0x1p-50 * std::sqrt(ball.r2);
  });
  return ball;
}

}  // namespace dynmesh::geometry
