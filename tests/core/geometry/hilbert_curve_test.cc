// The curve visits every cell once, each next to the one before, and coarser curves in order.
#include "core/geometry/hilbert_curve.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

namespace dynmesh::geometry::hilbert_curve_test {
namespace {

template <int D>
void ExpectGoesFromCellToCell(int levels) {
  using Cell = std::array<std::uint32_t, D>;
  const std::uint32_t side = 1u << levels, count = 1u << (levels * D);
  std::vector<Cell> by_key(count);
  std::vector<int> visits(count);
  for (std::uint32_t n = 0; n < count; ++n) {
    Cell cell, half;
    for (std::uint32_t i = 0, rest = n; i < D; ++i, rest /= side) {
      cell[i] = rest % side;
      half[i] = cell[i] / 2;
    }
    const std::uint32_t key = HilbertCurve<D>::Key(cell, levels);
    ASSERT_LT(key, count);
    ++visits[key];
    by_key[key] = cell;
    if (levels == 0) continue;
    ASSERT_EQ(HilbertCurve<D>::Key(half, levels - 1), key >> D);
  }
  for (std::uint32_t key = 0; key < count; ++key) {
    ASSERT_EQ(visits[key], 1);
    if (key == 0) continue;
    int distance = 0;
    for (std::size_t i = 0; i < D; ++i) {
      distance += std::abs(static_cast<int>(by_key[key][i]) - static_cast<int>(by_key[key - 1][i]));
    }
    ASSERT_EQ(distance, 1) << key;
  }
}

TEST(HilbertCurve, GoesFromCellToCell) {
  for (int levels = 0; levels <= 6; ++levels) ExpectGoesFromCellToCell<2>(levels);
  for (int levels = 0; levels <= 5; ++levels) ExpectGoesFromCellToCell<3>(levels);
}

}  // namespace
}  // namespace dynmesh::geometry::hilbert_curve_test
