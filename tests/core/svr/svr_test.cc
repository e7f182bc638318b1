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
#include <utility>
#include <vector>

#include "tests/core/svr/svr_of_points.h"
#include "tests/support/point_layouts.h"

namespace dynmesh::svr::svr_test {
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
class SvrTest : public ::testing::Test {};
using Cases =
    ::testing::Types<Case<2, VoronoiLocation<2, true>>, Case<2, VoronoiLocation<2, false>>,
                     Case<2, SimplexLocation<2>>, Case<2, BallLocation<2>>,
                     Case<3, VoronoiLocation<3, true>>, Case<3, VoronoiLocation<3, false>>,
                     Case<3, SimplexLocation<3>>, Case<3, BallLocation<3>>>;
TYPED_TEST_SUITE(SvrTest, Cases);

template <int D>
constexpr double kQuality = D == 2 ? std::numbers::sqrt2 : 2;

// True for exact circumcenters in the domain; BallOf is right to 10^-6.
constexpr double kRounding = 1 + 1e-5;

TYPED_TEST(SvrTest, MeshesAreGoodDelaunayAndHaveAllPoints) {
  constexpr int D = TypeParam::kDimension;
  using Location = typename TypeParam::Location;
  for (const Layout layout : kLayouts) {
    for (const double quality : {kQuality<D>, 2 * kQuality<D>}) {
      SCOPED_TRACE(std::string(NameOf(layout)) + ", quality " + std::to_string(quality));
      const auto points = PointsOf<D>(layout, D == 2 ? 2000 : 1000, 3);
      SvrOfPoints<D, Location> of(OptionsOf<D>(quality), points);
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
  constexpr int D = TypeParam::kDimension;
  using Location = typename TypeParam::Location;
  for (const Layout layout : kLayouts) {
    auto points = PointsOf<D>(layout, 500, 4);
    SvrOfPoints<D, Location> first(OptionsOf<D>(kQuality<D>), points);
    first.svr.Run([] { return false; });
    std::shuffle(points.begin(), points.end(), std::mt19937_64(5));
    SvrOfPoints<D, Location> second(OptionsOf<D>(kQuality<D>), points);
    second.svr.Run([] { return false; });
    EXPECT_EQ(PositionsOf<D>(first.mesh), PositionsOf<D>(second.mesh));
  }
}

// Worse than the intermediate bound q is only what the last insertions made, until it is split. A
// point is at (1 - k) R or farther from all vertices, R the radius of the simplex that it splits. A
// neighbour of that shares an edge <= 2 R. While no skinny simplex waits, the neighbour's radius is
// at most 2 R q, and so is that of what the point makes of it: 2 q / (1 - k) = 20 q. While one
// waits, the neighbour may be that one, and this is no bound. Twice as much is one for these
// points.
TYPED_TEST(SvrTest, NoMeshOnTheWayIsBad) {
  constexpr int D = TypeParam::kDimension;
  using Location = typename TypeParam::Location;
  double worst = 0, from_kept = 0, kept = 0;
  int times_kept = 0;
  for (const Layout layout : kLayouts) {
    SvrOfPoints<D, Location> of(OptionsOf<D>(kQuality<D>),
                                PointsOf<D>(layout, D == 2 ? 300 : 100, 6));
    auto& svr = of.svr;
    bool was_kept = true;
    svr.Run([&] {
      const double ratio = std::sqrt(svr.WorstSquaredRatio());
      worst = std::max(worst, ratio);
      if (was_kept) from_kept = std::max(from_kept, ratio);
      was_kept = svr.is_kept();
      if (!was_kept) return false;
      ++times_kept;
      kept = std::max(kept, ratio);
      return false;
    });
  }
  std::printf(
      "%dD: worst ratio on the way %.2f; %.2f after a mesh where nothing skinny waits, whose "
      "own is %.2f\n",
      D, worst, from_kept, kept);
  EXPECT_GT(times_kept, 500);
  EXPECT_LE(kept, 2 * kQuality<D> * kRounding);
  EXPECT_LT(from_kept, 20 * 2 * kQuality<D>);
  EXPECT_LT(worst, 2 * 20 * 2 * kQuality<D>);
}

TYPED_TEST(SvrTest, ARunCanBeInterruptedAndGoesOn) {
  constexpr int D = TypeParam::kDimension;
  using Location = typename TypeParam::Location;
  const auto points = PointsOf<D>(Layout::kUniform, 200, 8);
  SvrOfPoints<D, Location> whole(OptionsOf<D>(kQuality<D>), points);
  SvrOfPoints<D, Location> parts(OptionsOf<D>(kQuality<D>), points);
  whole.svr.Run([] { return false; });
  int runs = 0;
  for (int left = 7; !parts.svr.Run([&] { return left-- == 0; }); left = 7) ++runs;
  EXPECT_GT(runs, 10);
  EXPECT_EQ(PositionsOf<D>(whole.mesh), PositionsOf<D>(parts.mesh));
}

template <int D>
void ExpectShellsSpareLooks() {
  const auto points = PointsOf<D>(Layout::kTwoScales, D == 2 ? 5000 : 2000, 7);
  SvrOfPoints<D> shells(OptionsOf<D>(kQuality<D>), points);
  SvrOfPoints<D, VoronoiLocation<D, false>> plain(OptionsOf<D>(kQuality<D>), points);
  shells.svr.Run([] { return false; });
  plain.svr.Run([] { return false; });
  EXPECT_LT(2 * shells.svr.location().counts().looked_at, plain.svr.location().counts().looked_at);
}
TEST(VoronoiLocation, ShellsSpareLooks) {
  ExpectShellsSpareLooks<2>();
  ExpectShellsSpareLooks<3>();
}

}  // namespace
}  // namespace dynmesh::svr::svr_test
