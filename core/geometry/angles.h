// Angles as the mesher draws its lines. Pure functions, thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_ANGLES_H_
#define DYNMESH_CORE_GEOMETRY_ANGLES_H_

#include "core/geometry/point.h"
#include "core/geometry/predicates.h"

namespace dynmesh::geometry {

// Do apex-p and apex-q make an angle below 60 degrees? Less a hair, so that a lattice of
// regular triangles as rounded on entry has none. In doubles; symmetric in p and q to the bit.
inline bool IsSmallAngle(const Point2& apex, const Point2& p, const Point2& q) {
  constexpr double kSquaredCosine = 0.25 * (1 + 4e-6);
  const double ux = p[0] - apex[0], uy = p[1] - apex[1];
  const double wx = q[0] - apex[0], wy = q[1] - apex[1];
  const double dot = ux * wx + uy * wy;
  return dot > 0 && dot * dot > kSquaredCosine * ((ux * ux + uy * uy) * (wx * wx + wy * wy));
}

// Does the direction apex-p come before apex-q, counter-clockwise from straight up? Exact.
// REQUIRES: neither is the apex.
inline bool PrecedesInAngle(const Point2& apex, const Point2& p, const Point2& q) {
  const bool p_right = apex < p, q_right = apex < q;
  if (p_right != q_right) return q_right;
  return Orientation(apex, p, q) > 0;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_ANGLES_H_
