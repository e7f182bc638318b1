// The exact and the symbolic rungs of predicates.h.
#include "core/geometry/predicates.h"

#include <cassert>
#include <initializer_list>
#include <type_traits>

#include "core/geometry/exact_integer.h"

namespace dynmesh::geometry::internal {
namespace {

// Sizes. With coordinates of `width` bits in their common unit, differences stay below
// 2^(width+1). For N limbs we ask width + 1 <= 64N - 2, so differences d < 2^(64N-2);
// d*d < 2^(128N-4), sums of up to four of these < 2^(128N-2): 2N limbs with sign.
// In the in-circle polynomial, squares and cross products are sums of two, below
// 2^(128N-3); their products below 2^(256N-6), three of them below 2^(256N-4): 4N limbs.
constexpr int MaxWidth(int limbs) { return 64 * limbs - 3; }

// The whole domain: below 2^251 in units of 2^-302, width 553 <= MaxWidth(9) = 573.
constexpr int kMaxLimbs = 9;
static_assert(MaxWidth(kMaxLimbs) >= 251 + 302);

// Calls polynomial(integral<N>, exponent) with the least N of 1, 2, kMaxLimbs that the
// coordinates need.
template <class Polynomial>
int SignOf(std::initializer_list<double> coordinates, Polynomial polynomial) {
  const CommonUnit unit = FindCommonUnit(coordinates);
  if (unit.width <= MaxWidth(1)) {
    return polynomial(std::integral_constant<int, 1>{}, unit.exponent);
  }
  if (unit.width <= MaxWidth(2)) {
    return polynomial(std::integral_constant<int, 2>{}, unit.exponent);
  }
  assert(unit.width <= MaxWidth(kMaxLimbs));
  return polynomial(std::integral_constant<int, kMaxLimbs>{}, unit.exponent);
}

template <int N>
struct Vector {
  WideInt<N> x, y;

  // to - from, in units of 2^exponent.
  Vector(const Point2& from, const Point2& to, int exponent)
      : x(ToInteger<N>(to[0], exponent) - ToInteger<N>(from[0], exponent)),
        y(ToInteger<N>(to[1], exponent) - ToInteger<N>(from[1], exponent)) {}
};

template <int N>
WideInt<2 * N> CrossProduct(const Vector<N>& a, const Vector<N>& b) {
  return a.x * b.y - a.y * b.x;
}

template <int N>
WideInt<2 * N> DotProduct(const Vector<N>& a, const Vector<N>& b) {
  return a.x * b.x + a.y * b.y;
}

}  // namespace

int OrientationExact(const Point2& a, const Point2& b, const Point2& c) {
  return SignOf({a[0], a[1], b[0], b[1], c[0], c[1]}, [&](auto n, int exponent) {
    using V = Vector<n()>;
    return CrossProduct(V(c, a, exponent), V(c, b, exponent)).Sign();
  });
}

int InCircleExact(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return SignOf({a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]}, [&](auto n, int exponent) {
    using V = Vector<n()>;
    const V da(d, a, exponent), db(d, b, exponent), dc(d, c, exponent);
    const auto det = DotProduct(da, da) * CrossProduct(db, dc) +
                     DotProduct(db, db) * CrossProduct(dc, da) +
                     DotProduct(dc, dc) * CrossProduct(da, db);
    return det.Sign();
  });
}

int InDiametralBallExact(const Point2& a, const Point2& b, const Point2& x) {
  return SignOf({a[0], a[1], b[0], b[1], x[0], x[1]}, [&](auto n, int exponent) {
    using V = Vector<n()>;
    return DotProduct(V(x, a, exponent), V(x, b, exponent)).Sign();
  });
}

int CompareDistanceExact(const Point2& p, const Point2& a, const Point2& b) {
  return SignOf({p[0], p[1], a[0], a[1], b[0], b[1]}, [&](auto n, int exponent) {
    using V = Vector<n()>;
    const V pa(p, a, exponent), pb(p, b, exponent);
    return (DotProduct(pa, pa) - DotProduct(pb, pb)).Sign();
  });
}

// The Delaunay triangulation is the lower hull of the points lifted to z = x^2 + y^2.
// Perturb the lifting: let every point q of the plane rise by an infinitesimal e(q) > 0,
// where e(q) is infinitely greater than e(q') whenever q is lexicographically greater
// than q'. That is one fixed function of place (for any finite set, e = t^(n - rank)
// for a small enough t), whatever the set at hand, so all answers together are those of
// one lifted set in general position: its lower hull is a triangulation, it is unique,
// and no four lifted points are coplanar. As the e are infinitesimal, answers that were
// not ties stay, and no point leaves the hull (the paraboloid is strictly convex).
//
// What happens to d: it counts as inside if it lies below the plane of a, b, c. The
// in-circle determinant is linear in the four heights, with the coefficients
//   of z_a: |d b c|,  of z_b: |a d c|,  of z_c: |a b d|,  of z_d: -|a b c|,
// |...| being signed areas. At a tie only the e count, and the greatest outweighs the sum
// of the others unless its coefficient is zero. It never is: at a tie the four lie on one
// circle, and no three points of a circle are collinear. So the greatest point decides
// alone: if it is d, its negative coefficient says "outside".
bool InCircleTie(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const auto later = [](const Point2* p, const Point2* q) { return *p < *q ? q : p; };
  const Point2* const top = later(later(&a, &b), later(&c, &d));
  if (top == &a) return Orientation(d, b, c) > 0;
  if (top == &b) return Orientation(a, d, c) > 0;
  if (top == &c) return Orientation(a, b, d) > 0;
  return false;
}

bool InCircleSlow(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const int sign = InCircleExact(a, b, c, d);
  return sign != 0 ? sign > 0 : InCircleTie(a, b, c, d);
}

}  // namespace dynmesh::geometry::internal
