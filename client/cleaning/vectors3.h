// Vectors in 3D, in doubles. Pure.
#ifndef DYNMESH_CLIENT_CLEANING_VECTORS3_H_
#define DYNMESH_CLIENT_CLEANING_VECTORS3_H_

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

inline Point3 Minus(const Point3& a, const Point3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Point3 Along(const Point3& from, double t, const Point3& d) {
  return {from[0] + t * d[0], from[1] + t * d[1], from[2] + t * d[2]};
}
inline double Dot(const Point3& a, const Point3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Point3 Cross(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Point3 Opposite(const Point3& v) { return {-v[0], -v[1], -v[2]}; }
// The parameter in [0, 1] of the point of segment ab, a + t (b - a), that is nearest to p; 0 if a =
// b.
inline double NearestAlong(const Point3& a, const Point3& b, const Point3& p) {
  const Point3 d = Minus(b, a);
  const double length2 = Dot(d, d);
  return length2 > 0 ? std::clamp(Dot(d, Minus(p, a)) / length2, 0.0, 1.0) : 0;
}
// That point.
inline Point3 FootOn(const Point3& a, const Point3& b, const Point3& p) {
  return Along(a, NearestAlong(a, b, p), Minus(b, a));
}
inline Point3 UnitOf(const Point3& v) {
  const double length = std::sqrt(Dot(v, v));
  return {v[0] / length, v[1] / length, v[2] / length};
}
// Of triangle abc, by its orientation; twice as long as its area.
inline Point3 NormalOf(const Point3& a, const Point3& b, const Point3& c) {
  return Cross(Minus(b, a), Minus(c, a));
}
// The axis of the greatest component; of nearly equal ones the first, so that triangles in one
// plane mostly have one axis, however they are rounded.
inline std::size_t AxisOf(const Point3& v) {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(v[i]) > std::abs(v[axis]) * (1 + 1e-6)) axis = i;
  }
  return axis;
}
// The shadow along an axis.
inline Point ShadowOf(const Point3& p, std::size_t axis) {
  return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_VECTORS3_H_
