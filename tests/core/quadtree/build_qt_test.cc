// BuildQT: the tree of its definition, the same after any edits, at a price that does not grow.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/quadtree/build_qt_procedures.h"
#include "tests/core/quadtree/naive_quadtree.h"
#include "tests/core/quadtree/quadtree_scene.h"

namespace dynmesh::quadtree {
namespace {

using testing::NaiveQuadtree;
using testing::Scene;
using testing::UnitGrid;

template <int D>
using Dynamic = BuildQt<D, sac::Engine>;
template <int D>
using Static = BuildQt<D, sac::UntracedEngine>;

using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>,
                                    std::integral_constant<int, 4>>;

template <class T>
class BuildQtTest : public ::testing::Test {
 public:
  static constexpr int kDimension = T::value;
};
TYPED_TEST_SUITE(BuildQtTest, Dimensions);

template <int D, template <class> class E>
std::vector<Cell<D>> LeavesOf(const std::vector<Shape<D>>& shapes) {
  BuildQt<D, E> tree(UnitGrid<D>());
  for (const Shape<D>& shape : shapes) tree.Add(shape);
  EXPECT_TRUE(tree.Propagate());
  std::vector<Cell<D>> leaves = tree.Leaves();
  std::sort(leaves.begin(), leaves.end());
  return leaves;
}

TYPED_TEST(BuildQtTest, IsTheTreeOfTheDefinition) {
  constexpr int D = TestFixture::kDimension;
  for (std::uint64_t seed = 1; seed <= (D == 2 ? 40 : D == 3 ? 12 : 4); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene<D> scene(seed, 1 + static_cast<int>(seed % 8));
    const auto expected = NaiveQuadtree<D>(UnitGrid<D>(), scene.shapes()).Leaves();
    ASSERT_TRUE((LeavesOf<D, sac::UntracedEngine>(scene.shapes())) == expected);
    ASSERT_TRUE((LeavesOf<D, sac::Engine>(scene.shapes())) == expected);
  }
}

TEST(BuildQt, WithoutTwoFeaturesApartItIsTheRoot) {
  EXPECT_EQ((LeavesOf<2, sac::Engine>({})), std::vector{Cell<2>()});
  EXPECT_EQ((LeavesOf<2, sac::Engine>({Shape<2>::OfPoint({{0.5, 0.5}}, 0)})),
            std::vector{Cell<2>()});
  const std::vector<Shape<2>> star = {Shape<2>::OfSegment({{0.5, 0.5}}, {{0.9, 0.5}}, 0, 1),
                                      Shape<2>::OfSegment({{0.5, 0.5}}, {{0.5, 0.9}}, 0, 2),
                                      Shape<2>::OfPoint({{0.5, 0.5}}, 0)};
  EXPECT_EQ((LeavesOf<2, sac::Engine>(star)), std::vector{Cell<2>()});
}

// Plays edits, several features each, and compares with a new tree.
template <int D>
class Edits {
 public:
  Edits(std::uint64_t seed, int clusters)
      : scene_(seed, clusters), shapes_(scene_.shapes()), index_(shapes_.size(), kNone) {}

  void Toggle(std::size_t i) {
    if (index_[i] == kNone) {
      index_[i] = tree_.Add(shapes_[i]);
    } else {
      tree_.Remove(std::exchange(index_[i], kNone));
    }
  }
  void Change() {
    const int kind = scene_.Below(8), n = static_cast<int>(shapes_.size());
    int count = kind == 0 ? n / 2 : 1 + scene_.Below(3);
    if (kind == 1) {  // all that is there
      for (std::size_t i = 0; i < shapes_.size(); ++i) {
        if (index_[i] != kNone && scene_.Below(10) > 0) Toggle(i);
      }
    }
    while (count-- > 0) Toggle(static_cast<std::size_t>(scene_.Below(n)));
  }
  template <class Interrupt>
  bool Propagate(Interrupt interrupt) {
    return tree_.Propagate(interrupt);
  }

  void ExpectAsNew() {
    Dynamic<D> fresh(UnitGrid<D>());
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      if (index_[i] != kNone) fresh.Add(shapes_[i]);
    }
    ASSERT_TRUE(fresh.Propagate());
    std::vector<Cell<D>> leaves = tree_.Leaves();
    ASSERT_TRUE(leaves == fresh.Leaves());
    std::sort(leaves.begin(), leaves.end());
    std::vector<std::string> problems;
    const std::uint64_t hash = tree_.Audit(&problems);
    ASSERT_EQ(hash, fresh.Audit(&problems));
    ASSERT_TRUE(problems.empty()) << problems.front();
    // The differences lead from leaves to leaves.
    const LeafDiff<D> diff = tree_.TakeChanges();
    for (const Cell<D>& cell : diff.removed) ASSERT_EQ(leaves_.erase(cell), 1u);
    for (const Cell<D>& cell : diff.added) ASSERT_TRUE(leaves_.insert(cell).second);
    ASSERT_TRUE(std::ranges::equal(leaves_, leaves));
  }

  Scene<D>& scene() { return scene_; }
  Dynamic<D>& tree() { return tree_; }

 private:
  Scene<D> scene_;
  const std::vector<Shape<D>> shapes_;
  Dynamic<D> tree_{UnitGrid<D>()};
  std::vector<ShapeIndex> index_;
  std::set<Cell<D>> leaves_ = {Cell<D>()};
};

TYPED_TEST(BuildQtTest, AfterAnyEditsItIsTheTreeAndTheTraceOfANewRun) {
  constexpr int D = TestFixture::kDimension;
  for (std::uint64_t seed = 1; seed <= (D == 2 ? 30 : D == 3 ? 10 : 4); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Edits<D> edits(seed, 1 + static_cast<int>(seed % 10));
    for (int revision = 0; revision < 40; ++revision) {
      SCOPED_TRACE("revision " + std::to_string(revision));
      edits.Change();
      ASSERT_TRUE(edits.Propagate(sac::NoInterrupt()));
      edits.ExpectAsNew();
      if (this->HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(BuildQtTest, SoItIsWhereRunsAreInterrupted) {
  constexpr int D = TestFixture::kDimension;
  for (std::uint64_t seed = 1; seed <= (D == 2 ? 20 : 5); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Edits<D> edits(100 + seed, 1 + static_cast<int>(seed % 8));
    for (int revision = 0; revision < 30; ++revision) {
      SCOPED_TRACE("revision " + std::to_string(revision));
      for (int part = 0; part < 3; ++part) {
        edits.Change();
        int left = edits.scene().Below(60);
        edits.Propagate([&] { return left-- == 0; });
      }
      ASSERT_TRUE(edits.Propagate(sac::NoInterrupt()));
      edits.ExpectAsNew();
      if (this->HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(BuildQtTest, WhatIsGoneLeavesNothingBehind) {
  constexpr int D = TestFixture::kDimension;
  Scene<D> scene(7, 6);
  Dynamic<D> tree(UnitGrid<D>());
  std::vector<ShapeIndex> all;
  for (const Shape<D>& shape : scene.shapes()) all.push_back(tree.Add(shape));
  tree.Propagate();
  tree.TakeChanges();
  for (const ShapeIndex i : all) tree.Remove(i);
  tree.Propagate();
  tree.TakeChanges();
  EXPECT_EQ(tree.Leaves(), std::vector{Cell<D>()});
  EXPECT_EQ(tree.engine().operation_count(), 1u);
  EXPECT_EQ(tree.cell_count(), 1u);
}

}  // namespace
}  // namespace dynmesh::quadtree
