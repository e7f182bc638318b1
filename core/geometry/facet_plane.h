// The plane of a polygon in space.
//
// The polygon is given by its rings, closed chains of corners that lie in one plane up to
// rounding. Everything here is a function of the rings as chains, to the bit: the same wherever a
// ring begins, whichever way it goes, and in whatever order rings come. Pure functions,
// thread-safe.
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
  int axis = 0;         // the normal's largest component: shadows are along it

  // The distance from the plane, positive on the normal's side.
  double Height(const Point3& p) const { return Dot(normal, Difference(p.c, origin.c)); }
  Point3 Foot(const Point3& p) const {
    const double h = Height(p);
    return {{p[0] - h * normal[0], p[1] - h * normal[1], p[2] - h * normal[2]}};
  }
};

// Two directions in the plane, at right angles, of length 1 up to rounding.
std::array<Vector3, 2> AxesOf(const FacetPlane& plane);

// Of the ring that goes around the largest area. The normal is not a number if that is 0.
// O(corners).
FacetPlane PlaneOf(std::span<const Ring3> rings);

// How far the rings reach along the axes, and off the plane.
struct FacetBounds {
  Point3 lo = {}, hi = {};
  double deviation = 0;  // of the corner farthest from the plane
};
FacetBounds BoundsOf(std::span<const Ring3> rings, const FacetPlane& plane);

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_FACET_PLANE_H_
