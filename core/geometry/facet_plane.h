// The plane of a polygon in 3D.
//
// The polygon is given by its rings: closed chains of corners that lie in one plane up to rounding.
// Everything here is a function of the rings as chains, to the bit: it does not depend on a ring's
// first corner, its direction, or the order of rings. Pure functions, thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_FACET_PLANE_H_
#define DYNMESH_CORE_GEOMETRY_FACET_PLANE_H_

#include <array>
#include <span>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::geometry {

using Ring3 = std::vector<Point3>;

struct FacetPlane {
  Point3 origin = {};   // a corner
  Vector3 normal = {};  // of length 1 up to rounding; component `axis` is positive
  int axis = 0;         // index of the normal's largest component; shadows are along this axis

  // The signed distance from the plane, positive on the normal's side.
  double Height(const Point3& p) const { return Dot(normal, Difference(p.c, origin.c)); }
  Point3 Foot(const Point3& p) const {
    const double h = Height(p);
    return {{p[0] - h * normal[0], p[1] - h * normal[1], p[2] - h * normal[2]}};
  }
};

// Two orthogonal directions in the plane, of length 1 up to rounding.
std::array<Vector3, 2> AxesOf(const FacetPlane& plane);

// The plane of the ring around the largest area. The normal is NaN if that area is 0. O(corners).
FacetPlane PlaneOf(std::span<const Ring3> rings);

// The extent of the rings along the axes, and their deviation from the plane.
struct FacetBounds {
  Point3 lo = {}, hi = {};
  double deviation = 0;  // of the corner farthest from the plane
};
FacetBounds BoundsOf(std::span<const Ring3> rings, const FacetPlane& plane);

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_FACET_PLANE_H_
