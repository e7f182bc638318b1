// A box tree finds what a loop over all boxes finds, each once.
#include "core/base/box_tree.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/seed.h"

namespace dynmesh::boxes::box_tree_test {
namespace {

// Coordinates on a coarse grid: boxes that touch, points, and equal boxes are frequent.
template <std::size_t D>
Box<D> RandomBox(std::mt19937_64& rng) {
  std::uniform_int_distribution<int> at(-8, 8), extent(0, 3);
  Box<D> box;
  for (std::size_t k = 0; k < D; ++k) {
    box.low[k] = at(rng);
    box.high[k] = box.low[k] + extent(rng);
  }
  return box;
}

template <std::size_t D>
void ExpectAsALoop(std::mt19937_64& rng, std::size_t n) {
  std::vector<Box<D>> boxes;
  for (std::size_t i = 0; i < n; ++i) boxes.push_back(RandomBox<D>(rng));
  const BoxTree<D> tree(boxes);
  for (int query = 0; query < 30; ++query) {
    const Box<D> box = RandomBox<D>(rng);
    std::vector<std::uint32_t> found, expected;
    tree.ForEachMeeting(box, [&](std::uint32_t i) { found.push_back(i); });
    for (std::uint32_t i = 0; i < n; ++i) {
      if (boxes[i].Meets(box)) expected.push_back(i);
    }
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found, expected);
    ASSERT_EQ(tree.Meets(box), !expected.empty());
  }
}

TEST(BoxTree, FindsWhatALoopFinds) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(seed);
  std::mt19937_64 rng(seed);
  for (const std::size_t n : {0, 1, 6, 7, 100, 1000}) {
    ASSERT_NO_FATAL_FAILURE(ExpectAsALoop<2>(rng, n));
    ASSERT_NO_FATAL_FAILURE(ExpectAsALoop<3>(rng, n));
  }
}

TEST(Box, IsAroundItsCorners) {
  const std::array<std::array<double, 2>, 3> corners = {{{1, 5}, {3, 2}, {2, 9}}};
  const Box<2> box = Box<2>::Of(corners);
  EXPECT_EQ(box.low, (std::array<double, 2>{1, 2}));
  EXPECT_EQ(box.high, (std::array<double, 2>{3, 9}));
  EXPECT_TRUE(box.Meets({{3, 9}, {4, 10}}));  // touches
  EXPECT_FALSE(box.Meets({{3.5, 2}, {4, 3}}));
}

}  // namespace
}  // namespace dynmesh::boxes::box_tree_test
