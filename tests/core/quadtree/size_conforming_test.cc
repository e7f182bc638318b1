// The leaves follow the local feature size within the constants of Thm 4.1.4, and edits cost
// O(lg L/s): a number of operations that does not grow with the number of features.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/geometry/segment_distance.h"
#include "core/quadtree/build_qt_procedures.h"
#include "tests/core/quadtree/quadtree_scene.h"
#include "tests/support/point_layouts.h"

namespace dynmesh::quadtree {
namespace {

using test::Layout;
using test::PointsOf;
using testing::Scene;
using testing::UnitGrid;

// The radius of the least ball about x that meets two features without a common point.
template <int D>
double LocalFeatureSize(const Scene<D>& scene, const geometry::Point<D>& x) {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; i < scene.shapes().size(); ++i) {
    const auto& ends = scene.ends()[i];
    near.emplace_back(geometry::SquaredDistance(x, ends.p, ends.q), i);
  }
  std::sort(near.begin(), near.end());
  for (std::size_t j = 0; j < near.size(); ++j) {
    const auto of_j = scene.shapes()[near[j].second].points();
    for (std::size_t i = 0; i < j; ++i) {
      const auto of_i = scene.shapes()[near[i].second].points();
      const bool touch =
          std::ranges::any_of(of_i, [&](PointIndex p) { return std::ranges::count(of_j, p) > 0; });
      if (!touch) return std::sqrt(near[j].first);
    }
  }
  return INFINITY;
}

template <int D>
void ExpectSizeConforming(int scenes) {
  double least = INFINITY, most = 0;
  for (int seed = 1; seed <= scenes; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene<D> scene(static_cast<std::uint64_t>(seed), 2 + seed % 12, /*with_facets=*/false);
    BuildQt<D, sac::UntracedEngine> tree(UnitGrid<D>());
    for (const Shape<D>& shape : scene.shapes()) tree.Add(shape);
    tree.Propagate();
    for (int i = 0; i < 300; ++i) {
      // Anywhere, or near a feature.
      geometry::Point<D> x;
      const auto& ends =
          scene
              .ends()[static_cast<std::size_t>(scene.Below(static_cast<int>(scene.ends().size())))];
      const double spread = std::exp2(-scene.Uniform(0, 20)), part = scene.Uniform(0, 1);
      for (int k = 0; k < D; ++k) {
        x[k] = i % 2 == 0
                   ? scene.Uniform(0, 1)
                   : ends.p[k] + part * (ends.q[k] - ends.p[k]) + spread * scene.Uniform(-1, 1);
        x[k] = std::clamp(x[k], 0.0, 1.0);
      }
      const double size = LocalFeatureSize(scene, x);
      if (size == INFINITY) continue;
      const double ratio = size / tree.grid().Side(tree.LeafAt(x).level);
      least = std::min(least, ratio);
      most = std::max(most, ratio);
      ASSERT_GE(ratio, 0.25);
      ASSERT_LE(ratio, 4.5 * std::sqrt(D));
    }
  }
  std::printf("%dD: lfs / side between %.3f and %.3f\n", D, least, most);
  // The constants are not idle.
  EXPECT_LT(least, 1);
  EXPECT_GT(most, 2);
}

TEST(SizeConforming, LeavesFollowTheLocalFeatureSize) { ExpectSizeConforming<2>(60); }
TEST(SizeConforming, LeavesFollowTheLocalFeatureSizeIn3D) { ExpectSizeConforming<3>(40); }
TEST(SizeConforming, LeavesFollowTheLocalFeatureSizeIn4D) { ExpectSizeConforming<4>(20); }

TEST(SizeConforming, LeavesThatTouchDifferByAFactor2AtMost) {
  Scene<2> scene(5, 12, /*with_facets=*/false);
  BuildQt<2, sac::UntracedEngine> tree(UnitGrid<2>());
  for (const Shape<2>& shape : scene.shapes()) tree.Add(shape);
  tree.Propagate();
  const auto leaves = tree.Leaves();
  for (const Cell<2>& a : leaves) {
    for (const Cell<2>& b : leaves) {
      if (!tree.grid().BoxOf(a).Meets(tree.grid().BoxOf(b))) continue;
      ASSERT_LE(std::abs(a.level - b.level), 1);
    }
  }
}

// --- Cost of edits ------------------------------------------------------------------------------

template <int D>
void ExpectCheapEdits(int few, int many) {
  for (const Layout layout :
       {Layout::kUniform, Layout::kClustered, Layout::kCircle, Layout::kTwoScales, Layout::kLine}) {
    const char* const name = NameOf(layout);
    SCOPED_TRACE(name);
    for (const int n : {few, many}) {
      const auto points = PointsOf<D>(layout, n, 11);
      std::mt19937_64 random(12);
      BuildQt<D, sac::Engine> tree(UnitGrid<D>());
      std::vector<ShapeIndex> at;
      PointIndex next = 0;
      for (const auto& p : points) at.push_back(tree.Add(Shape<D>::OfPoint(p, next++)));
      tree.Propagate();
      tree.TakeChanges();
      tree.engine().ResetCounters();
      constexpr int kEdits = 200;
      std::uint64_t worst = 0, before = 0;
      for (int i = 0; i < kEdits; ++i) {
        const std::size_t j = random() % points.size();
        for (const bool comes : {false, true}) {
          if (comes) {
            at[j] = tree.Add(Shape<D>::OfPoint(points[j], static_cast<PointIndex>(j)));
          } else {
            tree.Remove(at[j]);
          }
          tree.Propagate();
          tree.TakeChanges();
          const auto& c = tree.engine().counters();
          const std::uint64_t now = c.executed + c.dropped;
          worst = std::max(worst, now - before);
          before = now;
        }
      }
      const double mean = static_cast<double>(before) / (2 * kEdits);
      std::printf("%dD %-10s n = %6zu: %.1f operations an edit, at most %llu\n", D, name,
                  points.size(), mean, static_cast<unsigned long long>(worst));
      // L/s is below 2^40 in all of them. A level has a few cells that an edit changes.
      EXPECT_LT(mean, D == 2 ? 16 : 32);
      EXPECT_LT(worst, D == 2 ? 100 : 200);
    }
  }
}

TEST(SizeConforming, AnEditRunsAFewOperations) { ExpectCheapEdits<2>(500, 20'000); }
TEST(SizeConforming, AnEditRunsAFewOperationsIn3D) { ExpectCheapEdits<3>(500, 10'000); }

}  // namespace
}  // namespace dynmesh::quadtree
