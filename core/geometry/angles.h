// Tests of angles for the mesher. Pure functions, thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_ANGLES_H_
#define DYNMESH_CORE_GEOMETRY_ANGLES_H_

#include "core/geometry/point.h"
#include "core/geometry/predicates.h"

namespace dynmesh::geometry {

// True if apex-p and apex-q make an angle below 60 degrees, less a tiny margin: a lattice of
// regular triangles, rounded on entry, has none. In doubles; symmetric in p and q to the bit.
template <int D>
inline bool IsSmallAngle(const Point<D>& apex, const Point<D>& p, const Point<D>& q) {
  constexpr double kSquaredCosine = 0.25 * (1 + 4e-6);
  double dot = 0, p2 = 0, q2 = 0;
  for (int i = 0; i < D; ++i) {
    const double u = p[i] - apex[i], w = q[i] - apex[i];
    dot += u * w, p2 += u * u, q2 += w * w;
  }
  return dot > 0 && dot * dot > kSquaredCosine * (p2 * q2);
}

// True if the direction apex-p comes before apex-q, counter-clockwise from straight up. Exact.
// REQUIRES: neither is the apex.
inline bool PrecedesInAngle(const Point2& apex, const Point2& p, const Point2& q) {
  const bool p_right = apex < p, q_right = apex < q;
  if (p_right != q_right) return q_right;
  return Orientation(apex, p, q) > 0;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_ANGLES_H_
