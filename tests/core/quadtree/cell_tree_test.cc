// The cells beside a cell, found by steps from parents to children, against their coordinates.
#include "core/quadtree/cell_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

namespace dynmesh::quadtree {
namespace {

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>,
                                    std::integral_constant<int, 4>>;

template <class T>
class CellTreeTest : public ::testing::Test {};
TYPED_TEST_SUITE(CellTreeTest, Dimensions);

// All records.
template <int D>
std::vector<CellIndex> CellsOf(const CellTree<D>& tree) {
  std::vector<CellIndex> cells = {kRoot};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!tree.HasChildren(cells[i])) continue;
    for (int which = 0; which < Cell<D>::kChildren; ++which) {
      cells.push_back(tree.ChildOf(cells[i], which));
    }
  }
  return cells;
}

// The cell, or the finest record that contains it, from the root down.
template <int D>
typename CellTree<D>::Found FindSlowly(const CellTree<D>& tree, const Cell<D>& cell) {
  for (int k = 0; k < D; ++k) {
    if (cell.at[k] >> cell.level != 0) return {};  // outside; below 0 it has wrapped around
  }
  CellIndex i = kRoot;
  int level = 0;
  for (; level < cell.level && tree.HasChildren(i); ++level) {
    int which = 0;
    for (int k = 0; k < D; ++k) {
      which |= static_cast<int>(cell.at[k] >> (cell.level - level - 1) & 1) << k;
    }
    i = tree.ChildOf(i, which);
  }
  return {i, level == cell.level};
}

template <int D>
Cell<D> CellBeside(const Cell<D>& cell, std::size_t offset) {
  Cell<D> beside = cell;
  for (int k = 0; k < D; ++k) {
    beside.at[k] += static_cast<std::uint64_t>(Offsets<D>::Along(offset, k));
  }
  return beside;
}

TYPED_TEST(CellTreeTest, BlocksAreTheCellsAround) {
  constexpr int D = TypeParam::value;
  constexpr std::uint64_t kSeed = 11;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  CellTree<D> tree;
  int coarser = 0;
  for (int step = 0; step < 1'500; ++step) {
    const std::vector<CellIndex> cells = CellsOf<D>(tree);
    // Half of the time near the last one, as callers do.
    const CellIndex i = cells[random() % 2 == 0 ? random() % cells.size()
                                                : cells.size() - 1 - random() % 4 % cells.size()];
    const Cell<D> cell = tree.CellOf(i);
    ASSERT_EQ(tree.MortonOf(i), cell.Morton());
    const auto block = tree.BlockAround(i);
    for (std::size_t offset = 0; offset < block.size(); ++offset) {
      const auto expected = FindSlowly<D>(tree, CellBeside<D>(cell, offset));
      ASSERT_EQ(block[offset].cell, expected.cell) << "step " << step << ", offset " << offset;
      ASSERT_EQ(block[offset].is_exact, expected.is_exact) << "step " << step;
      coarser += !expected.is_exact && expected.cell != kNone ? 1 : 0;
    }
    const std::size_t offset = random() % block.size();
    const CellIndex made = tree.MakeBeside(i, offset);
    const auto found = FindSlowly<D>(tree, CellBeside<D>(cell, offset));
    ASSERT_EQ(made, found.cell);
    ASSERT_TRUE(found.is_exact || made == kNone);
    if (cell.level < 7 && random() % 3 == 0) tree.MakeChildren(i);
    if (step % 100 == 99) tree.FreeUnused();  // no record is in use
  }
  EXPECT_GT(coarser, 500);
}

TYPED_TEST(CellTreeTest, CellsThatTouchAChildAreThoseOnItsSides) {
  constexpr int D = TypeParam::value;
  const Cell<D> parent = Cell<D>{3, {}}.Child(Cell<D>::kChildren - 1).Child(0);
  for (int which = 0; which < Cell<D>::kChildren; ++which) {
    const Cell<D> child = parent.Child(which);
    std::vector<std::size_t> touching;
    for (std::size_t offset = 0; offset < Offsets<D>::kCount; ++offset) {
      const Cell<D> beside = CellBeside<D>(parent, offset);
      bool touches = true;
      for (int k = 0; k < D; ++k) {
        // In units of the child's side, whose borders are child.at[k] and child.at[k] + 1.
        touches =
            touches && 2 * beside.at[k] <= child.at[k] + 1 && 2 * beside.at[k] + 2 >= child.at[k];
      }
      if (touches) touching.push_back(offset);
    }
    std::vector<std::size_t> listed;
    for (const std::size_t offset : Offsets<D>::kTouching[static_cast<std::size_t>(which)]) {
      listed.push_back(offset);
    }
    std::ranges::sort(listed);
    ASSERT_EQ(listed, touching) << "child " << which;
  }
}

}  // namespace
}  // namespace dynmesh::quadtree
