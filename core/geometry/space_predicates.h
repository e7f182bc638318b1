// Exact predicates in 3D: on which side of a plane, inside which sphere. Ladders as in
// predicates.h, with the same domain of coordinates. Products of five differences may overflow or
// underflow in doubles; then the filter does not know.
//
// Ties of InSphere are broken by one fixed infinitesimal lifting of all positions. So the Delaunay
// tetrahedralisation of a set of points is unique and has no flat tetrahedron: it is the regular
// triangulation of generic heights. Pure functions, thread-safe. Built without contraction into
// FMA.
#ifndef DYNMESH_CORE_GEOMETRY_SPACE_PREDICATES_H_
#define DYNMESH_CORE_GEOMETRY_SPACE_PREDICATES_H_

#include <cmath>

#include "core/geometry/point.h"
#include "core/geometry/predicates.h"

namespace dynmesh::geometry {
namespace internal {

int OrientationExact(const Point3& a, const Point3& b, const Point3& c, const Point3& d);
// Sign of the in-sphere determinant of positively oriented (a, b, c, d) and e: > 0 inside the open
// circumball, 0 on the sphere. No perturbation.
int InSphereExact(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                  const Point3& e);
// The result of InSphere for five points on one sphere.
bool InSphereTie(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                 const Point3& e);
// InSphere if the filter does not know.
bool InSphereSlow(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                  const Point3& e);

// A difference of points, rounded.
struct Offset3 {
  double x, y, z;
  Offset3(const Point3& from, const Point3& to)
      : x(to[0] - from[0]), y(to[1] - from[1]), z(to[2] - from[2]) {}
  double Square() const { return x * x + y * y + z * z; }
};

// A triple product and the sum of its terms' magnitudes.
struct Volume {
  double det, sum;
  Volume(const Offset3& a, const Offset3& b, const Offset3& c) {
    const double bycz = b.y * c.z, bzcy = b.z * c.y;
    const double bzcx = b.z * c.x, bxcz = b.x * c.z;
    const double bxcy = b.x * c.y, bycx = b.y * c.x;
    det = a.x * (bycz - bzcy) + a.y * (bzcx - bxcz) + a.z * (bxcy - bycx);
    sum = std::fabs(a.x) * (std::fabs(bycz) + std::fabs(bzcy)) +
          std::fabs(a.y) * (std::fabs(bzcx) + std::fabs(bxcz)) +
          std::fabs(a.z) * (std::fabs(bxcy) + std::fabs(bycx));
  }
};

inline int OrientationFilter(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const Volume v(Offset3(a, b), Offset3(a, c), Offset3(a, d));
  // Per term 3 differences, product 1, difference 1, product 1, sum of three 2: n = 8.
  return FilteredSign(v.det, 9 * kRoundoff * v.sum);
}

inline int InSphereFilter(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                          const Point3& e) {
  const Offset3 ea(e, a), eb(e, b), ec(e, c), ed(e, d);
  const Volume bcd(eb, ec, ed), acd(ea, ec, ed), abd(ea, eb, ed), abc(ea, eb, ec);
  const double a2 = ea.Square(), b2 = eb.Square(), c2 = ec.Square(), d2 = ed.Square();
  const double det = a2 * bcd.det - b2 * acd.det + (c2 * abd.det - d2 * abc.det);
  const double sum = a2 * bcd.sum + b2 * acd.sum + (c2 * abd.sum + d2 * abc.sum);
  // Per term: squares 3, sum of three 2; triple product 8; product 1, sum of four 2: n = 16.
  // Products of five may underflow, an absolute error of 2^-1074 each; 2^-1000 covers these and
  // what `sum` lost by them. If a product overflows, every comparison is false.
  return FilteredSign(det, 17 * kRoundoff * sum + 0x1p-1000);
}

}  // namespace internal

// Sign of the volume of (a, b, c, d), that is of (b - a) . ((c - a) x (d - a)): > 0 if the normal
// (c - b) x (d - b) points away from a; 0 if coplanar. Laws: even permutations keep it, odd ones
// negate it. Exact.
inline int Orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const int sign = internal::OrientationFilter(a, b, c, d);
  return sign != internal::kUnsure ? sign : internal::OrientationExact(a, b, c, d);
}

// True if e is inside the circumball of positively oriented (a, b, c, d), ties broken by the
// perturbation. Never "on". Precondition: e distinct from the four.
inline bool InSphere(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                     const Point3& e) {
  const int sign = internal::InSphereFilter(a, b, c, d, e);
  return sign != internal::kUnsure ? sign > 0 : internal::InSphereSlow(a, b, c, d, e);
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_SPACE_PREDICATES_H_
