// The root cell of a quadtree or octree. Pure function, O(D).
#ifndef DYNMESH_CORE_BASE_ROOT_CUBE_H_
#define DYNMESH_CORE_BASE_ROOT_CUBE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace dynmesh {

template <std::size_t D>
struct RootCube {
  std::array<double, D> lo{};
  int exponent = 0;  // its side is 2^exponent
};

// The cube is around the box from lo to hi; its side is a power of two, about 8/7 to 16/7 of the
// box's longest side (1, if that is 0). Its borders are multiples of an eighth of the side.
template <std::size_t D>
RootCube<D> RootAround(const std::array<double, D>& lo, const std::array<double, D>& hi) {
  RootCube<D> root;
  double extent = 0;
  for (std::size_t k = 0; k < D; ++k) extent = std::max(extent, hi[k] - lo[k]);
  if (!(extent > 0)) extent = 1;
  std::frexp(extent * (8.0 / 7), &root.exponent);  // < 2^exponent
  const auto place = [&] {
    const double unit = std::ldexp(1.0, root.exponent - 3);
    for (std::size_t k = 0; k < D; ++k) {
      root.lo[k] = std::floor(lo[k] / unit) * unit;
      if (root.lo[k] > lo[k]) root.lo[k] -= unit;  // the quotient has underflowed
    }
  };
  place();
  const double side = std::ldexp(1.0, root.exponent);
  for (std::size_t k = 0; k < D; ++k) {
    if (root.lo[k] + side >= hi[k]) continue;
    ++root.exponent;  // rounding has made the root too small
    place();
    break;
  }
  return root;
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_ROOT_CUBE_H_
