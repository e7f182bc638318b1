// 3D vectors in doubles, and the ball through the origin and three other points with an error
// bound. Pure, thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_CIRCUMBALL_H_
#define DYNMESH_CORE_GEOMETRY_CIRCUMBALL_H_

#include <array>
#include <cmath>

#include "core/geometry/point.h"

namespace dynmesh::geometry {

using Vector3 = std::array<double, 3>;

inline double Dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector3 Cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector3 Difference(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// The ball with 0, a, b and c on its surface; a2 is a . a, and so on. a . (b x c) must be positive
// (negative if `odd`). Where doubles cannot tell, nothing is known of the ball.
//
// w = (a^2 b x c + b^2 c x a + c^2 a x b) / (2 a . b x c). Its error, relative to
// S = (a^2 |b||c| + ...) / (2 det) >= |w|:
// 1. sums and products are right to 12 roundings;
// 2. the quotient to as many as the determinant has lost: |a||b||c| / det.
struct Circumball {
  Vector3 w = {0, 0, 0};    // the centre
  double r2 = INFINITY;     // the squared radius
  double error = INFINITY;  // bounds the error of each coordinate of w

  Circumball() = default;
  Circumball(const Vector3& a, double a2, const Vector3& b, double b2, const Vector3& c, double c2,
             bool odd) {
    const Vector3 bc = Cross(b, c), ca = Cross(c, a), ab = Cross(a, b);
    const double signed_det = Dot(a, bc);
    const double det = signed_det * (1 - 2 * static_cast<int>(odd));  // without a branch
    if (!(det > 0)) return;
    const double scale = 0.5 / signed_det;
    for (int k = 0; k < 3; ++k) w[k] = (a2 * bc[k] + b2 * ca[k] + c2 * ab[k]) * scale;
    r2 = Dot(w, w);
    const double la = Sum(a), lb = Sum(b), lc = Sum(c);
    const double half = std::fabs(scale);
    const double sum = (a2 * lb * lc + b2 * lc * la + c2 * la * lb) * half;
    error = 4e-15 * sum * (1 + 2 * la * lb * lc * half);
  }

 private:
  static double Sum(const Vector3& a) {
    return std::fabs(a[0]) + std::fabs(a[1]) + std::fabs(a[2]);
  }
};

// The same for four points that are not coplanar, seen from the first. Right to a few roundings
// however flat they are. Uses long integers: slow.
Circumball ExactCircumball(const Point3& p, const Point3& a, const Point3& b, const Point3& c);
// By doubles if these give the centre to a billionth of the shortest of pa, pb and pc, else by
// ExactCircumball. The same bits for any order of a, b and c. REQUIRES: (p, a, b, c) is positive.
Circumball CircumballOf(const Point3& p, const Point3& a, const Point3& b, const Point3& c);

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_CIRCUMBALL_H_
