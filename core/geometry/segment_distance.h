// Distances of points and segments in doubles, for rules that place vertices and for filters that
// leave room for rounding. The same arguments give the same bits. Thread-safe.
#ifndef DYNMESH_CORE_GEOMETRY_SEGMENT_DISTANCE_H_
#define DYNMESH_CORE_GEOMETRY_SEGMENT_DISTANCE_H_

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/point.h"

namespace dynmesh::geometry {

// The point of segment pq nearest to x; p = q is a point.
template <int D>
inline Point<D> NearestOn(const Point<D>& x, const Point<D>& p, const Point<D>& q) {
  double length2 = 0, along = 0;
  for (int k = 0; k < D; ++k) {
    length2 += (q[k] - p[k]) * (q[k] - p[k]);
    along += (x[k] - p[k]) * (q[k] - p[k]);
  }
  if (!(along > 0)) return p;
  if (along >= length2) return q;
  const double t = along / length2;
  Point<D> foot;
  for (int k = 0; k < D; ++k) foot[k] = p[k] + t * (q[k] - p[k]);
  return foot;
}

// Squared distance from x to segment pq; p = q is a point.
template <int D>
inline double SquaredDistance(const Point<D>& x, const Point<D>& p, const Point<D>& q) {
  return SquaredDistance(x, NearestOn(x, p, q));
}

// Squared distance of segments ab and pq that have no point in common; a = b and p = q are points.
template <int D>
inline double SquaredDistance(const Point<D>& a, const Point<D>& b, const Point<D>& p,
                              const Point<D>& q) {
  double best = std::min(std::min(SquaredDistance(a, p, q), SquaredDistance(b, p, q)),
                         std::min(SquaredDistance(p, a, b), SquaredDistance(q, a, b)));
  if constexpr (D == 3) {
    // Skew lines may be nearest in the interiors of both segments.
    double uu = 0, uv = 0, vv = 0, uw = 0, vw = 0;
    for (int k = 0; k < D; ++k) {
      const double u = b[k] - a[k], v = q[k] - p[k], w = p[k] - a[k];
      uu += u * u, uv += u * v, vv += v * v, uw += u * w, vw += v * w;
    }
    const double det = uu * vv - uv * uv;
    if (det > 1e-14 * uu * vv) {
      const double s = (uw * vv - uv * vw) / det, t = (uv * uw - uu * vw) / det;
      if (s > 0 && s < 1 && t > 0 && t < 1) {
        double d2 = 0;
        for (int k = 0; k < D; ++k) {
          const double d = (a[k] + s * (b[k] - a[k])) - (p[k] + t * (q[k] - p[k]));
          d2 += d * d;
        }
        best = std::min(best, d2);
      }
    }
  }
  return best;
}

// May segment pq meet the closed cube about `centre`? Conservative: true needlessly only if the
// segment is within rounding of the cube.
template <int D>
inline bool MayMeetCube(const Point<D>& centre, double half, const Point<D>& p, const Point<D>& q) {
  bool has_p = true, has_q = true;
  for (int k = 0; k < D; ++k) {
    const double lo = centre[k] - half, hi = centre[k] + half;
    if ((p[k] < lo && q[k] < lo) || (p[k] > hi && q[k] > hi)) return false;
    has_p = has_p && lo <= p[k] && p[k] <= hi;
    has_q = has_q && lo <= q[k] && q[k] <= hi;
  }
  if (has_p || has_q) return true;
  // Clips the segment's parameter by each pair of planes.
  double from = 0, to = 1;
  for (int k = 0; k < D; ++k) {
    const double lo = centre[k] - half, hi = centre[k] + half, d = q[k] - p[k];
    if (d == 0) continue;
    const double at_lo = (lo - p[k]) / d, at_hi = (hi - p[k]) / d;
    from = std::max(from, std::min(at_lo, at_hi));
    to = std::min(to, std::max(at_lo, at_hi));
  }
  return from <= to + 1e-9;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_SEGMENT_DISTANCE_H_
