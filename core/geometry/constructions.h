// Inexact constructions in doubles: new coordinates from old ones. Each is one fixed
// sequence of roundings, and symmetric to the bit where its comment says so; a caller
// that must not depend on history passes the points in a canonical order.
// Pure functions, thread-safe. Coordinates as in predicates.h.
#ifndef DYNMESH_CORE_GEOMETRY_CONSTRUCTIONS_H_
#define DYNMESH_CORE_GEOMETRY_CONSTRUCTIONS_H_

#include <array>

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

// The circumcenter of (p, q, c), computed about c; symmetric in p and q to the bit. Not
// finite if the three are collinear in doubles.
inline Point2 Circumcenter(const Point2& p, const Point2& q, const Point2& c) {
  const double px = p[0] - c[0], py = p[1] - c[1];
  const double qx = q[0] - c[0], qy = q[1] - c[1];
  const double p2 = px * px + py * py, q2 = qx * qx + qy * qy;
  const double scale = 0.5 / (px * qy - py * qx);
  return {{c[0] + (qy * p2 - py * q2) * scale, c[1] + (px * q2 - qx * p2) * scale}};
}

// The same of the corners of a simplex and another one, about that other.
inline Point2 Circumcenter(const std::array<Point2, 2>& corners, const Point2& c) {
  return Circumcenter(corners[0], corners[1], c);
}
inline Point3 Circumcenter(const std::array<Point3, 3>& corners, const Point3& d) {
  std::array<std::array<double, 3>, 3> x;
  std::array<double, 3> x2;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) x[i][k] = corners[i][k] - d[k];
    x2[i] = x[i][0] * x[i][0] + x[i][1] * x[i][1] + x[i][2] * x[i][2];
  }
  const auto cross = [&](int i, int j, int k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    return x[i][l] * x[j][m] - x[i][m] * x[j][l];
  };
  const double det = x[0][0] * cross(1, 2, 0) + x[0][1] * cross(1, 2, 1) + x[0][2] * cross(1, 2, 2);
  Point3 centre = d;
  for (int k = 0; k < 3; ++k) {
    centre[k] +=
        (x2[0] * cross(1, 2, k) + x2[1] * cross(2, 0, k) + x2[2] * cross(0, 1, k)) * (0.5 / det);
  }
  return centre;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_CONSTRUCTIONS_H_
