// Points on a line. Pure, thread-safe, O(1).
#ifndef DYNMESH_CORE_GEOMETRY_COLLINEAR_H_
#define DYNMESH_CORE_GEOMETRY_COLLINEAR_H_

#include <cmath>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"
#include "core/geometry/predicates.h"

namespace dynmesh::geometry {

// Are all three on one line? Exact: in 3D iff they are in all projections along an axis.
inline bool AreCollinear(const Point2& a, const Point2& b, const Point2& c) {
  return Orientation(a, b, c) == 0;
}
inline bool AreCollinear(const Point3& a, const Point3& b, const Point3& c) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    if (!AreCollinear(Point2{{a[u], a[v]}}, Point2{{b[u], b[v]}}, Point2{{c[u], c[v]}})) {
      return false;
    }
  }
  return true;
}

// The distance of p from the line through two different points. Rounded.
inline double DistanceToLine(const Point3& p, const Point3& a, const Point3& b) {
  const Vector3 way = Difference(b.c, a.c);
  const Vector3 cross = Cross(way, Difference(p.c, a.c));
  return std::sqrt(Dot(cross, cross) / Dot(way, way));
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_COLLINEAR_H_
