// How round a tetrahedron is, where doubles cannot tell. Exact integers, rounded once at the end or
// not at all. Coordinates as in predicates.h. Pure functions, thread-safe; about a microsecond for
// coordinates of ordinary width.
#ifndef DYNMESH_CORE_GEOMETRY_TETRAHEDRON_SHAPE_H_
#define DYNMESH_CORE_GEOMETRY_TETRAHEDRON_SHAPE_H_

#include "core/geometry/point.h"

namespace dynmesh::geometry {

struct TetrahedronShape {
  double determinant;  // (b - a) . ((c - a) x (d - a)), six times the volume
  double radius_edge;  // circumradius / shortest edge; infinity if flat; for either orientation
};

// Both with a relative error below 2^-49; the sign of the determinant is right.
TetrahedronShape ShapeOf(const Point3& a, const Point3& b, const Point3& c, const Point3& d);

// The sign of circumradius / shortest edge - bound. Exact for bounds up to 2^52. A flat tetrahedron
// exceeds every bound.
int CompareRadiusEdge(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                      double bound);

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_TETRAHEDRON_SHAPE_H_
