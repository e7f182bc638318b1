// 3D vectors in CGAL's rationals: the slow arithmetic of oracles.
#ifndef DYNMESH_TESTS_CORE_GEOMETRY_RATIONAL_VECTORS_H_
#define DYNMESH_TESTS_CORE_GEOMETRY_RATIONAL_VECTORS_H_

#include <CGAL/Exact_rational.h>

#include <array>

#include "core/geometry/point.h"

namespace dynmesh::geometry::testing {

using Q = CGAL::Exact_rational;
using QVector = std::array<Q, 3>;

inline int SignOf(const Q& q) { return q > 0 ? 1 : q < 0 ? -1 : 0; }

inline QVector From(const Point3& p, const Point3& q) {
  return {Q(q[0]) - Q(p[0]), Q(q[1]) - Q(p[1]), Q(q[2]) - Q(p[2])};
}
inline Q Dot(const QVector& a, const QVector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Q Det(const QVector& a, const QVector& b, const QVector& c) {
  const QVector cross = {b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2],
                         b[0] * c[1] - b[1] * c[0]};
  return Dot(a, cross);
}

}  // namespace dynmesh::geometry::testing

#endif  // DYNMESH_TESTS_CORE_GEOMETRY_RATIONAL_VECTORS_H_
