// The exact and the symbolic rungs of space_predicates.h.
#include "core/geometry/space_predicates.h"

#include <algorithm>
#include <array>

#include "core/geometry/exact_vector.h"

namespace dynmesh::geometry::internal {

int OrientationExact(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  for (int i = 0; i < 3; ++i) {
    if (a[i] == b[i] && a[i] == c[i] && a[i] == d[i]) return 0;  // as on a face of a box
  }
  return SignOf({&a, &b, &c, &d}, [&](auto n, int exponent) {
    using V = Vector<n(), 3>;
    return TripleProduct(V(a, b, exponent), V(a, c, exponent), V(a, d, exponent)).Sign();
  });
}

int InSphereExact(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                  const Point3& e) {
  return SignOf({&a, &b, &c, &d, &e}, [&](auto n, int exponent) {
    using V = Vector<n(), 3>;
    const V ea(e, a, exponent), eb(e, b, exponent), ec(e, c, exponent), ed(e, d, exponent);
    const auto det = DotProduct(ea, ea) * TripleProduct(eb, ec, ed) -
                     DotProduct(eb, eb) * TripleProduct(ea, ec, ed) +
                     DotProduct(ec, ec) * TripleProduct(ea, eb, ed) -
                     DotProduct(ed, ed) * TripleProduct(ea, eb, ec);
    return det.Sign();
  });
}

// As in 2D (predicates.cc, InCircleTie) every position rises by an infinitesimal, which is
// infinitely greater than that of any position before it in lexicographic order.
// 1. The determinant is linear in the heights. The coefficient of one of a, b, c, d is the volume
//    of the four with e in its place; that of e is minus the volume of the four.
// 2. At a tie the greatest position with a nonzero coefficient decides.
// 3. In 3D a coefficient may be zero: if the four other points lie on one circle. Not all are zero,
//    since that of e is not.
bool InSphereTie(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                 const Point3& e) {
  // The points from the greatest down. Mostly the first decides, so they are not sorted. Equal ones
  // stay in this order.
  std::array<const Point3*, 5> left = {&a, &b, &c, &d, &e};
  for (std::size_t count = left.size(); count > 0; --count) {
    std::size_t greatest = 0;
    for (std::size_t i = 1; i < count; ++i) greatest = *left[greatest] < *left[i] ? i : greatest;
    const Point3* const p = left[greatest];
    std::copy(left.begin() + greatest + 1, left.begin() + count, left.begin() + greatest);
    const int sign = p == &a   ? Orientation(e, b, c, d)
                     : p == &b ? Orientation(a, e, c, d)
                     : p == &c ? Orientation(a, b, e, d)
                     : p == &d ? Orientation(a, b, c, e)
                               : -1;
    if (sign != 0) return sign > 0;
  }
  return false;
}

bool InSphereSlow(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                  const Point3& e) {
  const int sign = InSphereExact(a, b, c, d, e);
  return sign != 0 ? sign > 0 : InSphereTie(a, b, c, d, e);
}

}  // namespace dynmesh::geometry::internal
