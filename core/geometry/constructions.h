// Inexact constructions in doubles: new coordinates from old ones. Each is one fixed sequence of
// roundings, and symmetric to the bit where its comment says so. A caller that must not depend on
// history passes the points in a canonical order. Pure functions, thread-safe. Coordinates as in
// predicates.h.
#ifndef DYNMESH_CORE_GEOMETRY_CONSTRUCTIONS_H_
#define DYNMESH_CORE_GEOMETRY_CONSTRUCTIONS_H_

#include <array>
#include <cmath>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::geometry {

// Twice the signed area of (a, b, c), computed about c: swapping a and b negates it to
// the bit, other permutations may round otherwise.
inline double Cross(const Point2& a, const Point2& b, const Point2& c) {
  return (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0]);
}

// The middle of ab; symmetric to the bit.
template <int D>
inline Point<D> Midpoint(const Point<D>& a, const Point<D>& b) {
  Point<D> m;
  for (int i = 0; i < D; ++i) m[i] = 0.5 * (a[i] + b[i]);
  return m;
}

// The off-center of an edge of length e: the apex of the isosceles triangle over it with ratio
// rho. So its other sides have length sqrt(B) e, and it is `height` e above the edge's middle.
inline double OffCenterB(double rho) {
  const double rho2 = rho * rho;
  return 2 * rho2 + std::sqrt(4 * rho2 * rho2 - rho2);
}
inline double OffCenterHeight(double rho) { return std::sqrt(OffCenterB(rho) - 0.25); }
// To the left of pq.
inline Point2 OffCenter(const Point2& p, const Point2& q, double height) {
  return {
      {0.5 * (p[0] + q[0]) - height * (q[1] - p[1]), 0.5 * (p[1] + q[1]) + height * (q[0] - p[0])}};
}

// The circumcenter of (p, q, c), computed about c; symmetric in p and q to the bit. Not
// finite if the three are collinear in doubles.
inline Point2 Circumcenter(const Point2& p, const Point2& q, const Point2& c) {
  const double px = p[0] - c[0], py = p[1] - c[1];
  const double qx = q[0] - c[0], qy = q[1] - c[1];
  const double p2 = px * px + py * py, q2 = qx * qx + qy * qy;
  const double scale = 0.5 / (px * qy - py * qx);
  return {{c[0] + (qy * p2 - py * q2) * scale, c[1] + (px * q2 - qx * p2) * scale}};
}

// The same for the corners of a simplex and another point c, computed about c.
inline Point2 Circumcenter(const std::array<Point2, 2>& corners, const Point2& c) {
  return Circumcenter(corners[0], corners[1], c);
}
inline Point3 Circumcenter(const std::array<Point3, 3>& corners, const Point3& d) {
  std::array<Vector3, 3> x;
  for (int i = 0; i < 3; ++i) x[i] = Difference(corners[i].c, d.c);
  const bool odd = Dot(x[0], Cross(x[1], x[2])) < 0;
  const Circumball ball(x[0], Dot(x[0], x[0]), x[1], Dot(x[1], x[1]), x[2], Dot(x[2], x[2]), odd);
  if (!(ball.r2 < INFINITY)) return {{INFINITY, INFINITY, INFINITY}};
  return {{d[0] + ball.w[0], d[1] + ball.w[1], d[2] + ball.w[2]}};
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_CONSTRUCTIONS_H_
