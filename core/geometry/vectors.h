// Vectors of doubles in D dimensions, rounded. For 3D alone see circumball.h, too; the bits are the
// same. Pure functions.
#ifndef DYNMESH_CORE_GEOMETRY_VECTORS_H_
#define DYNMESH_CORE_GEOMETRY_VECTORS_H_

#include <array>
#include <cstddef>

#include "core/geometry/point.h"

namespace dynmesh::geometry {

// p - q.
template <int D>
std::array<double, D> Minus(const Point<D>& p, const Point<D>& q) {
  std::array<double, D> d;
  for (int i = 0; i < D; ++i) d[static_cast<std::size_t>(i)] = p[i] - q[i];
  return d;
}

// The summands in the order of the axes.
template <std::size_t D>
double Dot(const std::array<double, D>& u, const std::array<double, D>& w) {
  double sum = u[0] * w[0];
  for (std::size_t i = 1; i < D; ++i) sum += u[i] * w[i];
  return sum;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_VECTORS_H_
