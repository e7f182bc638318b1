// Exact predicates in 2D, and those that are alike in all dimensions; those in 3D are in
// space_predicates.h. Each is a ladder of rungs:
// 1. a filter in doubles that may not know (inline, here);
// 2. exact integer arithmetic (exact_integer.h);
// 3. where a tie has to be broken, a symbolic perturbation. It depends on coordinates alone, never
//    on ids, addresses or order of arrival. So the Delaunay triangulation of a set of points is
//    unique.
//
// Coordinates: finite, magnitude 0 or in [2^-250, 2^250]; the caller has checked it. So differences
// are 0 or in [2^-302, 2^251]. Products of two are normal numbers. Products of four cannot overflow
// (below 2^1008), and where they underflow the filters return that they do not know. Pure
// functions, thread-safe. Built without contraction into FMA.
#ifndef DYNMESH_CORE_GEOMETRY_PREDICATES_H_
#define DYNMESH_CORE_GEOMETRY_PREDICATES_H_

#include <cmath>
#include <optional>

#include "core/geometry/point.h"

namespace dynmesh::geometry {

// The rungs; the public ladders follow. Filters return kUnsure or the exact sign.
namespace internal {

inline constexpr int kUnsure = 2;
inline constexpr double kRoundoff = 0x1p-53;

int OrientationExact(const Point2& a, const Point2& b, const Point2& c);
// Sign of the in-circle determinant of counter-clockwise (a, b, c) and d: > 0 inside the open
// circumdisc, 0 on the circle. No perturbation.
int InCircleExact(const Point2& a, const Point2& b, const Point2& c, const Point2& d);
template <int D>
int InDiametralBallExact(const Point<D>& a, const Point<D>& b, const Point<D>& x);
// The result of InCircle for four points on one circle.
bool InCircleTie(const Point2& a, const Point2& b, const Point2& c, const Point2& d);
// InCircle if the filter does not know.
bool InCircleSlow(const Point2& a, const Point2& b, const Point2& c, const Point2& d);

// The sign of `value` if it exceeds `bound`, the greatest possible error.
inline int FilteredSign(double value, double bound) {
  if (value > bound) return 1;
  if (value < -bound) return -1;
  return kUnsure;
}

// How the bounds below come about, u = 2^-53.
// 1. A sum of products is computed from differences of coordinates; each operation has a relative
//    error of at most u.
// 2. If every product (one term of the expanded polynomial) passes through at most n roundings on
//    its way to the result, the result errs by at most ((1+u)^n - 1) sum|terms|.
// 3. The computed sum of |terms| (its own roundings at most n) is at least (1-u)^n of the true one.
// 4. Thus (n + 1) u times the computed sum bounds the error, for n < 100, with room for the
//    roundings of the bound itself.

inline int OrientationFilter(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (a[0] - c[0]) * (b[1] - c[1]);
  const double right = (a[1] - c[1]) * (b[0] - c[0]);
  // Per term 2 differences, 1 product, 1 last difference: n = 4.
  return FilteredSign(left - right, 5 * kRoundoff * (std::fabs(left) + std::fabs(right)));
}

inline int InCircleFilter(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const double ax = a[0] - d[0], ay = a[1] - d[1];
  const double bx = b[0] - d[0], by = b[1] - d[1];
  const double cx = c[0] - d[0], cy = c[1] - d[1];
  const double bxcy = bx * cy, cxby = cx * by;
  const double cxay = cx * ay, axcy = ax * cy;
  const double axby = ax * by, bxay = bx * ay;
  const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  const double det = a2 * (bxcy - cxby) + b2 * (cxay - axcy) + c2 * (axby - bxay);
  const double sum = a2 * (std::fabs(bxcy) + std::fabs(cxby)) +
                     b2 * (std::fabs(cxay) + std::fabs(axcy)) +
                     c2 * (std::fabs(axby) + std::fabs(bxay));
  // Per term: square 3, sum of squares 1; cross product 3, difference 1; product 1,
  // sum of three 2: n = 11. The products of four may underflow, an absolute error of
  // 2^-1074 each; 2^-1000 covers these and what `sum` lost by them.
  return FilteredSign(det, 12 * kRoundoff * sum + 0x1p-1000);
}

template <int D>
inline int InDiametralBallFilter(const Point<D>& a, const Point<D>& b, const Point<D>& x) {
  double dot = (a[0] - x[0]) * (b[0] - x[0]), sum = std::fabs(dot);
  for (int i = 1; i < D; ++i) {
    const double product = (a[i] - x[i]) * (b[i] - x[i]);
    dot += product;
    sum += std::fabs(product);
  }
  // Differences 2, product 1, sum of D terms D - 1: n = D + 2.
  return FilteredSign(dot, (D + 3) * kRoundoff * sum);
}

}  // namespace internal

// Sign of the signed area of (a, b, c): > 0 counter-clockwise, 0 collinear.
// Laws: cyclic shifts keep it, swaps negate it. Exact.
inline int Orientation(const Point2& a, const Point2& b, const Point2& c) {
  const int sign = internal::OrientationFilter(a, b, c);
  return sign != internal::kUnsure ? sign : internal::OrientationExact(a, b, c);
}

// True if d is inside the circumdisc of counter-clockwise (a, b, c), ties broken by the
// lexicographic perturbation. Never "on": four distinct points always get an answer, consistent
// over any set of points. So Delaunay is unique. Precondition: a, b, c not collinear,
// counter-clockwise; d distinct from them.
inline bool InCircle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const int sign = internal::InCircleFilter(a, b, c, d);
  return sign != internal::kUnsure ? sign > 0 : internal::InCircleSlow(a, b, c, d);
}

// (a - x).(b - x): < 0 inside the ball with diameter ab, 0 on its surface. Exact.
template <int D>
inline int DiametralBallSign(const Point<D>& a, const Point<D>& b, const Point<D>& x) {
  const int sign = internal::InDiametralBallFilter(a, b, x);
  return sign != internal::kUnsure ? sign : internal::InDiametralBallExact(a, b, x);
}

// True if x is strictly inside that ball.
template <int D>
inline bool InDiametralBall(const Point<D>& a, const Point<D>& b, const Point<D>& x) {
  return DiametralBallSign(a, b, x) < 0;
}

// Does the ray from p to the right cross the edge ab, of which the lower end is part and the upper
// one is not? A horizontal edge is never crossed. Nothing if p is on the closed edge. So p is
// inside a polygon, off its edges, if it crosses an odd number of them. Symmetric in a and b.
// Exact.
inline std::optional<bool> CrossesEdge(const Point2& p, const Point2& a, const Point2& b) {
  const Point2& lo = a[1] < b[1] || (a[1] == b[1] && a[0] < b[0]) ? a : b;
  const Point2& hi = &lo == &a ? b : a;
  if (p[1] < lo[1] || p[1] > hi[1]) return false;
  if (lo[1] == hi[1]) {
    return lo[0] <= p[0] && p[0] <= hi[0] ? std::nullopt : std::optional(false);
  }
  const int side = Orientation(lo, hi, p);
  if (side == 0) return std::nullopt;
  return side > 0 && p[1] < hi[1];
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_PREDICATES_H_
