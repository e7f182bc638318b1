#include "core/geometry/circumball.h"

#include "core/geometry/exact_vector.h"

namespace dynmesh::geometry {

// Numerators and determinant of the formula as integers, then one division.
Circumball ExactCircumball(const Point3& p, const Point3& a, const Point3& b, const Point3& c) {
  Circumball ball;
  internal::SignOf({&p, &a, &b, &c}, [&](auto n, int exponent) {
    const internal::ExactCentre<n()> centre(p, a, b, c, exponent);
    const ScaledDouble det = ToScaledDouble(centre.det);
    if (det.mantissa == 0) return 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const ScaledDouble sum = ToScaledDouble(centre.n[k]);
      ball.w[k] =
          std::ldexp(0.5 * sum.mantissa / det.mantissa, sum.exponent - det.exponent + exponent);
    }
    ball.r2 = Dot(ball.w, ball.w);
    ball.error = 0x1p-50 * std::sqrt(ball.r2);
    return 1;
  });
  return ball;
}

}  // namespace dynmesh::geometry
