// Points in D dimensions, as plain values.
#ifndef DYNMESH_CORE_GEOMETRY_POINT_H_
#define DYNMESH_CORE_GEOMETRY_POINT_H_

#include <array>
#include <bit>
#include <cstdint>

#include "core/base/mix.h"

namespace dynmesh::geometry {

template <int D>
struct Point {
  std::array<double, D> c;
  double operator[](int i) const { return c[i]; }
  double& operator[](int i) { return c[i]; }
  friend bool operator==(const Point&, const Point&) = default;
  // Lexicographic: the order that decides every symbolic tie.
  friend bool operator<(const Point& a, const Point& b) { return a.c < b.c; }
};

using Point2 = Point<2>;
using Point3 = Point<3>;

// (a - b)^2 as computed in doubles: relative error below 4 * 2^-53, symmetric in
// a and b to the bit.
template <int D>
inline double SquaredDistance(const Point<D>& a, const Point<D>& b) {
  double sum = 0;
  for (int i = 0; i < D; ++i) {
    const double d = a[i] - b[i];
    sum += d * d;
  }
  return sum;
}

// The random priority of a position (-0 counts as +0). It orders work within a bucket and breaks
// the chains of Fig. 4.8 on every input. Two points may collide; then coordinates decide.
template <int D>
inline std::uint64_t HashOf(const Point<D>& p) {
  std::uint64_t h = 0x2545f4914f6cdd1dULL;
  for (int i = 0; i < D; ++i) h = Mix(h ^ std::bit_cast<std::uint64_t>(p[i] + 0.0));
  return h;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_POINT_H_
