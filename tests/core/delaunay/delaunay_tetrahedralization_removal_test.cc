// Removal of vertices, including those of large degree and on the box's faces and edges: the result
// must be as if they had never been inserted.
#include <gtest/gtest.h>

#include "tests/core/delaunay/tetrahedra_oracle.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay::delaunay_tetrahedralization_removal_test {
namespace {

using namespace testing;
using geometry::testing::NewSeed;

// After the removal of a hub in the midst of points of one sphere, all is as if it had never been
// inserted.
void ExpectHubLeavesNoTrace(const Point3& hub, std::size_t least_degree) {
  std::vector<Point3> rim;
  for (const Point3& p : IntegerSphere(hub, 1.0 / 16)) {
    if (p[0] >= kLow[0] && p[1] >= kLow[1] && p[2] >= kLow[2]) rim.push_back(p);
  }
  auto dt = Tetrahedralize(rim);
  const auto expected = TetrahedraOf(dt);
  dt.Insert(1000, hub, 8);
  ExpectSound(dt);
  EXPECT_GE(dt.created().size(), least_degree);
  const std::size_t created = dt.created().size();
  dt.Remove(1000);
  EXPECT_EQ(dt.deleted().size(), created);
  EXPECT_EQ(TetrahedraOf(dt), expected);
  ExpectSound(dt);
}

TEST(TetrahedraRemoval, OfTheHubOfASphereLeavesNoTrace) {
  ExpectHubLeavesNoTrace({{0, 1, 0}}, 200);
}
TEST(TetrahedraRemoval, OfAHubOnAFaceLeavesNoTrace) {
  ExpectHubLeavesNoTrace({{0, 1, kLow[2]}}, 100);
}
TEST(TetrahedraRemoval, OfAHubOnAnEdgeLeavesNoTrace) {
  ExpectHubLeavesNoTrace({{0, kLow[1], kLow[2]}}, 50);
}

// Neighbours from a few to hundreds: all sizes of rims.
TEST(TetrahedraRemoval, OfTheMiddleOfRoundedSpheresIsRightForEveryDegree) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Point3 hub{{0, 1, 0}};
  for (int count = 0; count < 150; count += 3) {
    std::vector<Point3> points;
    for (int i = 0; i < count; ++i) {
      const double x = normal(random), y = normal(random), z = normal(random);
      const double r = std::sqrt(x * x + y * y + z * z);
      points.push_back({{hub[0] + x / r, hub[1] + y / r, hub[2] + z / r}});
    }
    auto dt = Tetrahedralize(points);
    const auto expected = TetrahedraOf(dt);
    dt.Insert(1000, hub, 0);
    ExpectSound(dt);
    dt.Remove(1000);
    ASSERT_EQ(TetrahedraOf(dt), expected) << count;
    ExpectSound(dt);
  }
}

TEST(TetrahedraRemoval, OfEverythingOnTheFacesOneByOneRestoresTheBareBox) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  const auto points = DistinctPoints(Layout::kBoxFaces, seed, 300);
  auto dt = Tetrahedralize(points);
  auto order = IndicesFrom8(points.size());
  std::mt19937_64 random(seed);
  std::shuffle(order.begin(), order.end(), random);
  for (const VertexIndex victim : order) {
    dt.Remove(victim);
    ASSERT_NO_FATAL_FAILURE(ExpectSound(dt));
  }
  EXPECT_EQ(TetrahedraOf(dt), TetrahedraOf(EmptyBox()));
}

TEST(TetrahedraRemoval, ReusesTetrahedraAndScratch) {
  const auto points = DistinctPoints(Layout::kUniform, 8, 1000);
  auto dt = Tetrahedralize(points);
  const auto expected = TetrahedraOf(dt);
  const auto round = [&] {
    for (VertexIndex i = 0; i < points.size(); ++i) dt.Remove(8 + i);
    ASSERT_EQ(TetrahedraOf(dt), TetrahedraOf(EmptyBox()));
    for (VertexIndex i = 0; i < points.size(); ++i) dt.Insert(8 + i, points[i], 0);
    ASSERT_EQ(TetrahedraOf(dt), expected);
  };
  for (int i = 0; i < 2; ++i) round();
  const std::size_t limit = dt.simplex_limit(), bytes = dt.bytes();
  for (int i = 0; i < 3; ++i) round();
  EXPECT_EQ(dt.simplex_limit(), limit);
  EXPECT_EQ(dt.bytes(), bytes);
  ExpectSound(dt);
}

}  // namespace
}  // namespace dynmesh::delaunay::delaunay_tetrahedralization_removal_test
