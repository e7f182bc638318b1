// The root cell is around what it was asked for, whatever rounding does; the order of cells.
#include "core/quadtree/cell.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace dynmesh::quadtree {
namespace {

TEST(Grid, TheRootIsAroundTheBox) {
  constexpr std::uint64_t kSeed = 3;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 20'000; ++i) {
    geometry::Point<2> lo, hi;
    // Near 7/8 of a power of two a root of that side barely fits, or does not.
    double extent = std::ldexp(0.875, static_cast<int>(random() % 20) - 10);
    for (int j = static_cast<int>(random() % 5); j > 2; --j) extent = std::nextafter(extent, 1e9);
    for (int j = static_cast<int>(random() % 3); j > 1; --j) extent = std::nextafter(extent, 0);
    for (int k = 0; k < 2; ++k) {
      lo[k] = std::ldexp(any(random), static_cast<int>(random() % 20) - 10);
      if (i % 3 == 0) lo[k] = std::nextafter(std::ldexp(std::round(16 * lo[k]), -3), -1e9);
      hi[k] = lo[k] + extent;
    }
    const Grid<2> grid(lo, hi);
    const Box<2> root = grid.BoxOf(Cell<2>());
    ASSERT_TRUE(root.Holds(lo) && root.Holds(hi)) << lo[0] << " " << lo[1] << " " << extent;
    ASSERT_LE(grid.Side(0), 3 * extent);
  }
}

TEST(Grid, HalvesOfACellAreItsChildren) {
  const Grid<3> grid({{-0.3, 7, 0}}, {{0.4, 7.5, 0.1}});
  Cell<3> cell;
  for (; cell.level < grid.most_level(); cell = cell.Child(5 & cell.level)) {
    for (int which = 0; which < Cell<3>::kChildren; ++which) {
      const Box<3> expected = grid.BoxOf(cell.Child(which));
      const Box<3> child = grid.HalvesOf(cell).Child(which);
      ASSERT_TRUE(child.lo == expected.lo && child.hi == expected.hi) << cell.level;
    }
  }
}

TEST(Grid, CellsHaveExactBorders) {
  const Grid<2> grid({{1e5, -3}}, {{1e5 + 1, -2.5}});
  Cell<2> cell;
  while (cell.level < grid.most_level()) cell = cell.Child(3 & cell.level);
  const Box<2> box = grid.BoxOf(cell);
  for (int k = 0; k < 2; ++k) EXPECT_EQ(box.hi[k] - box.lo[k], grid.Side(cell.level));
}

// Bit by bit.
template <int D>
std::uint64_t SlowMorton(const Cell<D>& cell) {
  constexpr int kBits = 64 / D;
  std::uint64_t code = 0;
  for (int k = 0; k < D; ++k) {
    for (int bit = 0; bit < kBits; ++bit) {  // from the most significant one
      if (bit >= cell.level) break;
      const std::uint64_t value = cell.at[k] >> (cell.level - 1 - bit) & 1;
      code |= value << (D * (kBits - 1 - bit) + k);
    }
  }
  return code;
}
template <int D>
void ExpectMorton() {
  std::mt19937_64 random(9);
  for (int i = 0; i < 2'000; ++i) {
    Cell<D> cell;
    cell.level = static_cast<int>(random() % (kMostLevel + 1));
    for (int k = 0; k < D && cell.level > 0; ++k) cell.at[k] = random() >> (64 - cell.level);
    ASSERT_EQ(cell.Morton(), SlowMorton<D>(cell)) << D << "D, level " << cell.level;
    const int which = static_cast<int>(random() % Cell<D>::kChildren);
    ASSERT_EQ(Cell<D>::MortonOfChild(cell.Morton(), cell.level, which), cell.Child(which).Morton())
        << D << "D, level " << cell.level << ", child " << which;
  }
}
TEST(Cell, MortonInterleavesTheLeadingBits) {
  ExpectMorton<2>();
  ExpectMorton<3>();
  ExpectMorton<4>();
}

}  // namespace
}  // namespace dynmesh::quadtree
