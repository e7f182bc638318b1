// Canonical constructions: near the truth, and symmetric to the bit where promised.
#include "core/geometry/constructions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/geometry/random_points.h"

namespace dynmesh::geometry::constructions_test {
namespace {

TEST(Constructions, CircumcenterIsEquidistant) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  testing::PointSource<2> source(testing::Kind::kUniform, seed);
  for (int i = 0; i < 5000; ++i) {
    const Point2 p = source.Next(), q = source.Next(), c = source.Next();
    if (std::fabs(Cross(p, q, c)) < 1e-3) continue;
    const Point2 o = Circumcenter(p, q, c);
    const double r = std::sqrt(SquaredDistance(o, c));
    ASSERT_NEAR(std::sqrt(SquaredDistance(o, p)), r, 1e-11 * (1 + r) * r);
    ASSERT_NEAR(std::sqrt(SquaredDistance(o, q)), r, 1e-11 * (1 + r) * r);
  }
  EXPECT_EQ(Circumcenter({{4, 0}}, {{0, 2}}, {{0, 0}}), (Point2{{2, 1}}));
}

TEST(Constructions, AreSymmetricToTheBit) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const testing::Kind kind : {testing::Kind::kUniform, testing::Kind::kScales}) {
    testing::PointSource<2> source(kind, seed);
    for (int i = 0; i < 5000; ++i) {
      const Point2 p = source.Next(), q = source.Next(), c = source.Next();
      ASSERT_EQ(Cross(p, q, c), -Cross(q, p, c));
      ASSERT_EQ(Midpoint(p, q), Midpoint(q, p));
      if (Cross(p, q, c) != 0) {
        ASSERT_EQ(Circumcenter(p, q, c), Circumcenter(q, p, c));
      }
    }
  }
}

TEST(Constructions, TheOffCentersTriangleHasTheRatio) {
  for (const double rho : {1.0, 1.2, 1.4142135623730951, 3.0}) {
    const Point2 p = {{3, 1}}, q = {{1, 4}}, apex = OffCenter(p, q, OffCenterHeight(rho));
    EXPECT_GT(Cross(p, q, apex), 0);
    const double e2 = SquaredDistance(p, q);
    EXPECT_NEAR(SquaredDistance(p, apex), OffCenterB(rho) * e2, 1e-12 * e2);
    EXPECT_NEAR(SquaredDistance(q, apex), OffCenterB(rho) * e2, 1e-12 * e2);
    const double r2 = SquaredDistance(p, Circumcenter(p, q, apex));
    EXPECT_NEAR(r2, rho * rho * e2, 1e-12 * e2);
  }
}

TEST(Constructions, MidpointLiesBetween) {
  const Point2 m = Midpoint(Point2{{0, 2}}, Point2{{1, 5}});
  EXPECT_EQ(m, (Point2{{0.5, 3.5}}));
}

}  // namespace
}  // namespace dynmesh::geometry::constructions_test
