// Directions and points as data: sines of parts of a turn, the 26 directions to the neighbours of a
// grid cell, points spread over a ball. They are not computed by libm, because meshes depend on
// their bits.
#ifndef DYNMESH_CORE_MESHING_DIRECTIONS_H_
#define DYNMESH_CORE_MESHING_DIRECTIONS_H_

#include <array>
#include <cstddef>

#include "core/geometry/circumball.h"

namespace dynmesh::meshing {

// Cosine and sine of k / 32 of a turn.
inline constexpr int kDirections = 32;
inline double SineOf(int k) {
  constexpr double kSines[9] = {0.0,
                                0.19509032201612825,
                                0.38268343236508977,
                                0.55557023301960218,
                                0.70710678118654757,
                                0.83146961230254524,
                                0.92387953251128674,
                                0.98078528040323043,
                                1.0};
  k &= kDirections - 1;
  if (k >= 16) return -SineOf(k - 16);
  return kSines[k <= 8 ? k : 16 - k];
}
inline double CosineOf(int k) { return SineOf(k + 8); }

// Unit vectors, in lexicographic order.
inline constexpr std::array<geometry::Vector3, 26> kGridDirections = [] {
  constexpr double kLength[4] = {0, 1, 0.70710678118654757, 0.57735026918962576};
  std::array<geometry::Vector3, 26> all{};
  std::size_t count = 0;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const double length = kLength[x * x + y * y + z * z];
        if (length > 0) all[count++] = {x * length, y * length, z * length};
      }
    }
  }
  return all;
}();

// Points spread evenly over the open unit ball: a Halton sequence of bases 2, 3 and 5.
inline constexpr std::array<geometry::Vector3, 1000> kBallPositions = [] {
  const auto part = [](int i, int base) {
    double sum = 0, unit = 1;
    for (; i > 0; i /= base) {
      unit /= base;
      sum += unit * (i % base);
    }
    return 2 * sum - 1;
  };
  std::array<geometry::Vector3, 1000> all{};
  std::size_t count = 0;
  for (int i = 1; count < all.size(); ++i) {
    const geometry::Vector3 x = {part(i, 2), part(i, 3), part(i, 5)};
    if (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < 1) all[count++] = x;
  }
  return all;
}();

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_DIRECTIONS_H_
