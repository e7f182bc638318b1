// The plane of a facet: rings of places in space that lie in one plane, as nearly as doubles let
// them. A function of the rings as sets of edges: not of where a ring starts, which way round it
// goes, or which ring comes first; so everyone who asks gets the same bits.
//
// The normal is that of the ring with the largest area, its sum taken from the ring's least corner
// towards the lesser neighbour, with the largest component made positive. The plane lies in the
// middle between the corners farthest to either side. Pure, thread-safe. O(corners).
#ifndef DYNMESH_CORE_GEOMETRY_FACET_PLANE_H_
#define DYNMESH_CORE_GEOMETRY_FACET_PLANE_H_

#include <vector>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::geometry {

struct FacetPlane {
  Vector3 normal = {0, 0, 0};  // of length 1; 0 if no ring has an area
  Point3 origin{};             // the least corner
  double offset = 0;           // of the plane from there, along the normal
  double deviation = 0;        // the distance of the farthest corner
  double area = 0;             // of the largest ring
  int drop = 2;                // the axis nearest to the normal

  // Signed: positive on the side to which the normal points. It errs by a few spacings of the
  // doubles of p and the corners.
  double Distance(const Point3& p) const { return Dot(normal, Difference(p.c, origin.c)) - offset; }
  // The place of the plane nearest to p.
  Point3 Foot(const Point3& p) const {
    const double d = Distance(p);
    return {{p[0] - d * normal[0], p[1] - d * normal[1], p[2] - d * normal[2]}};
  }
  // Without the axis `drop`: what turns counter-clockwise there does so seen from the normal's tip.
  Point2 Project(const Point3& p) const { return {{p[(drop + 1) % 3], p[(drop + 2) % 3]}}; }
};

FacetPlane PlaneOf(const std::vector<std::vector<Point3>>& rings);

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_FACET_PLANE_H_
