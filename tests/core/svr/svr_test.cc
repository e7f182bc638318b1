// Sparse Voronoi Refinement of points: all of them are vertices, every simplex is good, the mesh is
// Delaunay and a function of the set of points, and no mesh on the way is much worse.
#include "core/svr/svr.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/core/svr/svr_of_points.h"
#include "tests/support/point_layouts.h"

namespace dynmesh::svr {
namespace {

using test::kLayouts;
using test::Layout;
using test::PointsOf;

template <int D>
Options<D> OptionsOf(double quality) {
  Options<D> options;
  options.border_cells = D == 2 ? 6 : 8;
  options.lo.c.fill(0.5 - 0.5 * options.border_cells);
  options.hi.c.fill(0.5 + 0.5 * options.border_cells);
  options.quality = quality;
  return options;
}

// In the order of the vertices' indices.
template <int D>
auto PositionsOf(const Kernel<D>& mesh) {
  std::vector<geometry::Point<D>> positions;
  for (VertexIndex v = 0; v < mesh.vertex_count(); ++v) positions.push_back(mesh.position(v));
  return positions;
}

template <class T>
class SvrTest : public ::testing::Test {
 public:
  static constexpr int kDimension = T::value;
};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(SvrTest, Dimensions);

template <int D>
constexpr double kQuality = D == 2 ? std::numbers::sqrt2 : 2;

// True for exact circumcenters in the domain; BallOf is right to 10^-6.
constexpr double kRounding = 1 + 1e-5;

TYPED_TEST(SvrTest, MeshesAreGoodDelaunayAndHaveAllPoints) {
  constexpr int D = TestFixture::kDimension;
  for (const Layout layout : kLayouts) {
    for (const double quality : {kQuality<D>, 2 * kQuality<D>}) {
      SCOPED_TRACE(std::string(NameOf(layout)) + ", quality " + std::to_string(quality));
      const auto points = PointsOf<D>(layout, D == 2 ? 2000 : 1000, 3);
      SvrOfPoints<D> of(OptionsOf<D>(quality), points);
      ASSERT_TRUE(of.svr.Run([] { return false; }));
      std::string why;
      ASSERT_TRUE(of.mesh.Check(&why)) << why;
      EXPECT_LE(std::sqrt(of.svr.WorstSquaredRatio()), quality * kRounding);
      EXPECT_EQ(of.svr.counts().outside, 0u);
      std::set<geometry::Point<D>> inserted;
      for (VertexIndex v = 0; v < of.mesh.vertex_count(); ++v) {
        if (of.input.IsInput(v)) inserted.insert(of.mesh.position(v));
      }
      EXPECT_TRUE(std::ranges::equal(inserted, points));
    }
  }
}

TYPED_TEST(SvrTest, TheOrderOfTheInputDoesNotMatter) {
  constexpr int D = TestFixture::kDimension;
  for (const Layout layout : kLayouts) {
    auto points = PointsOf<D>(layout, 500, 4);
    SvrOfPoints<D> first(OptionsOf<D>(kQuality<D>), points);
    first.svr.Run([] { return false; });
    std::shuffle(points.begin(), points.end(), std::mt19937_64(5));
    SvrOfPoints<D> second(OptionsOf<D>(kQuality<D>), points);
    second.svr.Run([] { return false; });
    EXPECT_EQ(PositionsOf<D>(first.mesh), PositionsOf<D>(second.mesh));
  }
}

// Worse than the intermediate bound q is only what the last insertion made, until it is split. A
// point is at (1 - k) R or farther from all vertices, R the radius of the simplex that it splits. A
// neighbour of that shares an edge <= 2 R, so its radius is at most 2 R q, and so is that of what
// the point makes of it: 2 q / (1 - k) = 20 q.
TYPED_TEST(SvrTest, NoMeshOnTheWayIsBad) {
  constexpr int D = TestFixture::kDimension;
  double worst = 0, kept = 0;
  int times_kept = 0;
  for (const Layout layout : kLayouts) {
    SvrOfPoints<D> of(OptionsOf<D>(kQuality<D>), PointsOf<D>(layout, D == 2 ? 300 : 100, 6));
    auto& svr = of.svr;
    svr.Run([&] {
      const double ratio = std::sqrt(svr.WorstSquaredRatio());
      worst = std::max(worst, ratio);
      if (!svr.is_kept()) return false;
      ++times_kept;
      kept = std::max(kept, ratio);
      return false;
    });
  }
  std::printf("%dD: worst ratio on the way %.2f; %.2f where nothing skinny waits\n", D, worst,
              kept);
  EXPECT_GT(times_kept, 500);
  EXPECT_LE(kept, 2 * kQuality<D> * kRounding);
  EXPECT_LT(worst, 20 * 2 * kQuality<D>);
}

TYPED_TEST(SvrTest, ShellsSpareLooks) {
  constexpr int D = TestFixture::kDimension;
  const auto points = PointsOf<D>(Layout::kTwoScales, D == 2 ? 5000 : 2000, 7);
  SvrOfPoints<D> shells(OptionsOf<D>(kQuality<D>), points);
  SvrOfPoints<D, VoronoiLocation<D, false>> plain(OptionsOf<D>(kQuality<D>), points);
  shells.svr.Run([] { return false; });
  plain.svr.Run([] { return false; });
  EXPECT_LT(2 * shells.svr.location().counts().looked_at, plain.svr.location().counts().looked_at);
}

TYPED_TEST(SvrTest, ARunCanBeInterruptedAndGoesOn) {
  constexpr int D = TestFixture::kDimension;
  const auto points = PointsOf<D>(Layout::kUniform, 200, 8);
  SvrOfPoints<D> whole(OptionsOf<D>(kQuality<D>), points);
  SvrOfPoints<D> parts(OptionsOf<D>(kQuality<D>), points);
  whole.svr.Run([] { return false; });
  int runs = 0;
  for (int left = 7; !parts.svr.Run([&] { return left-- == 0; }); left = 7) ++runs;
  EXPECT_GT(runs, 10);
  EXPECT_EQ(PositionsOf<D>(whole.mesh), PositionsOf<D>(parts.mesh));
}

}  // namespace
}  // namespace dynmesh::svr
