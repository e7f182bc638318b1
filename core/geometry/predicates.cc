// The exact and the symbolic rungs of predicates.h.
#include "core/geometry/predicates.h"

#include "core/geometry/exact_vector.h"

// A program that compiles these sources with its own may set flags for both.
#ifdef __FAST_MATH__
#error "dynmesh cannot be compiled with -ffast-math or -Ofast: meshes would depend on the compiler"
#endif

namespace dynmesh::geometry::internal {

int OrientationExact(const Point2& a, const Point2& b, const Point2& c) {
  return SignOf({&a, &b, &c}, [&](auto n, int exponent) {
    using V = Vector<n(), 2>;
    return CrossProduct(V(c, a, exponent), V(c, b, exponent)).Sign();
  });
}

int InCircleExact(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return SignOf({&a, &b, &c, &d}, [&](auto n, int exponent) {
    using V = Vector<n(), 2>;
    const V da(d, a, exponent), db(d, b, exponent), dc(d, c, exponent);
    const auto det = DotProduct(da, da) * CrossProduct(db, dc) +
                     DotProduct(db, db) * CrossProduct(dc, da) +
                     DotProduct(dc, dc) * CrossProduct(da, db);
    return det.Sign();
  });
}

template <int D>
int InDiametralBallExact(const Point<D>& a, const Point<D>& b, const Point<D>& x) {
  return SignOf({&a, &b, &x}, [&](auto n, int exponent) {
    using V = Vector<n(), D>;
    return DotProduct(V(x, a, exponent), V(x, b, exponent)).Sign();
  });
}

template int InDiametralBallExact(const Point2&, const Point2&, const Point2&);
template int InDiametralBallExact(const Point3&, const Point3&, const Point3&);

// The Delaunay triangulation is the lower hull of the points lifted to z = x^2 + y^2.
// 1. Perturb the lifting: let every point q of the 2D plane rise by an infinitesimal e(q) > 0,
//    where e(q) is infinitely greater than e(q') whenever q is lexicographically greater than q'.
//    This is one fixed function of position (for a finite set e = t^(n - rank), t small enough),
//    whatever the set.
// 2. So all answers together are those of one lifted set in general position: its lower hull is a
//    triangulation, it is unique, and no four lifted points are coplanar.
// 3. As the e are infinitesimal, answers that were not ties stay, and no point leaves the hull (the
//    paraboloid is strictly convex).
//
// Point d counts as inside if it lies below the plane of a, b, c. The in-circle determinant is
// linear in the four heights, with the coefficients
//   of z_a: |d b c|,  of z_b: |a d c|,  of z_c: |a b d|,  of z_d: -|a b c|,
// |...| being signed areas. At a tie only the e count, and the greatest outweighs the sum of the
// others unless its coefficient is zero. It never is: at a tie the four lie on one circle, and no
// three points of a circle are collinear. So the greatest point alone decides; if it is d, its
// negative coefficient says "outside".
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
