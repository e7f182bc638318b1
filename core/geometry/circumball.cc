#include "core/geometry/circumball.h"

#include "core/geometry/exact_vector.h"

namespace dynmesh::geometry {

// Numerators and determinant of the formula as integers, then one division.
Circumball ExactCircumball(const Point3& p, const Point3& a, const Point3& b, const Point3& c) {
  Circumball ball;
  internal::SignOf({&p, &a, &b, &c}, [&](auto n, int exponent) {
    using V = internal::Vector<n(), 3>;
    const V u(p, a, exponent), v(p, b, exponent), w(p, c, exponent);
    const auto u2 = DotProduct(u, u), v2 = DotProduct(v, v), w2 = DotProduct(w, w);
    const ScaledDouble det = ToScaledDouble(TripleProduct(u, v, w));
    if (det.mantissa == 0) return 0;
    const auto cross = [](const V& x, const V& y, int k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      return x.c[i] * y.c[j] - x.c[j] * y.c[i];
    };
    for (int k = 0; k < 3; ++k) {
      const ScaledDouble sum =
          ToScaledDouble(u2 * cross(v, w, k) + v2 * cross(w, u, k) + w2 * cross(u, v, k));
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
