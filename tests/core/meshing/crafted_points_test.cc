// Points with priorities (a public hash) chosen by a client: a run takes as many steps per
// operation as on any other input.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/refinement.h"
#include "tests/support/crafted.h"

namespace dynmesh::meshing::crafted_points_test {
namespace {

template <int D>
MeshOptions Options() {
  MeshOptions options;
  options.dimension = D;
  options.quality = DefaultQuality(D);
  return options;
}

// All share their 40 leading bits.
template <int D>
std::vector<geometry::Point<D>> ClusteredPoints(int n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<geometry::Point<D>> points;
  while (points.size() < static_cast<std::size_t>(n)) {
    points.push_back({test::PlaceOfHash<D>(
        test::kPriorityKey, [&] { return std::uint64_t{0xabcdef1234} << 24 | random() >> 40; },
        random)});
  }
  return points;
}

// The number of steps to find the times of all operations, per operation.
template <int D>
double StepsEach(int n) {
  const auto points = ClusteredPoints<D>(n, 5);
  EXPECT_EQ(geometry::HashOf(points[0]) >> 24, geometry::HashOf(points[1]) >> 24);
  Refinement<D, sac::Engine> refinement(Options<D>(), nullptr);
  refinement.Propagate([] { return false; });
  FeatureSlot slot = 1;
  for (const auto& p : points) refinement.AddPoint(p, slot++);
  refinement.Propagate([] { return false; });
  const auto& engine = refinement.engine();
  EXPECT_GT(engine.operation_count(), static_cast<std::size_t>(n));
  return static_cast<double>(engine.order_steps()) / static_cast<double>(engine.operation_count());
}

TEST(CraftedPoints, OfOnePriorityBitsTakeNoMoreStepsTheMoreThereAre) {
  for (const int n : {2'500, 5'000, 10'000}) EXPECT_LT(StepsEach<2>(n), 8) << n;
  for (const int n : {500, 1'000, 2'000}) EXPECT_LT(StepsEach<3>(n), 8) << n;
}

// Two lines at right angles: a tetrahedron for each pair of their edges, unless few points tell and
// the triangulation is left. Rounds by bits of hashes would put all into one.
TEST(CraftedPoints, BetweenLinesDoNotFillATriangulation) {
  constexpr int kEach = 2'000;
  std::vector<geometry::Point3> points;
  for (int i = 0, taken = 0; taken < 2 * kEach; ++i) {
    const double t = 0.3 + 0.4 * std::fmod(i * 0.6180339887498949, 1.0);
    const geometry::Point3 p =
        taken % 2 == 0 ? geometry::Point3{{t, 0.5, 0.4}} : geometry::Point3{{0.5, t, 0.6}};
    if (geometry::HashOf(p) >> 63 == 0) continue;  // no leading zero: all in the last round
    points.push_back(p);
    ++taken;
  }
  delaunay::DelaunayTetrahedralization triangulation;
  Refinement<3, sac::UntracedEngine> refinement(Options<3>(), &triangulation);
  FeatureSlot slot = 1;
  for (const auto& p : points) refinement.AddPoint(p, slot++);
  // It has been left once the first operations run; memory tells how large it was.
  int asked = 0;
  refinement.Propagate([&] { return ++asked > 100; });
  EXPECT_LT(triangulation.simplex_limit(), 1'000u);
  EXPECT_LT(triangulation.bytes(), std::size_t{2} * kEach * 64 * 72);
}

}  // namespace
}  // namespace dynmesh::meshing::crafted_points_test
