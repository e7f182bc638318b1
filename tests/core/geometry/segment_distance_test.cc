#include "core/geometry/segment_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/workload.h"

namespace dynmesh::geometry::segment_distance_test {
namespace {

template <int D>
Point<D> RandomPoint(test::Random& random) {
  Point<D> p;
  for (int k = 0; k < D; ++k) p[k] = 2 * random.Unit() - 1;
  return p;
}
template <int D>
Point<D> Between(const Point<D>& p, const Point<D>& q, double t) {
  Point<D> x;
  for (int k = 0; k < D; ++k) x[k] = p[k] + t * (q[k] - p[k]);
  return x;
}

template <int D>
void CompareWithSamples() {
  test::Random random(D);
  constexpr int kSteps = 200;
  for (int i = 0; i < 200; ++i) {
    const auto a = RandomPoint<D>(random), b = RandomPoint<D>(random), p = RandomPoint<D>(random),
               q = random.OneIn(4) ? p : RandomPoint<D>(random);
    double to_point = INFINITY, to_segment = INFINITY;
    for (int s = 0; s <= kSteps; ++s) {
      const auto x = Between(p, q, static_cast<double>(s) / kSteps);
      to_point = std::min(to_point, std::sqrt(SquaredDistance(a, x)));
      for (int t = 0; t <= kSteps; ++t) {
        const auto y = Between(a, b, static_cast<double>(t) / kSteps);
        to_segment = std::min(to_segment, std::sqrt(SquaredDistance(x, y)));
      }
    }
    // Samples are at most 4 / kSteps apart.
    const double d = std::sqrt(SquaredDistance(a, p, q));
    EXPECT_LE(d, to_point + 1e-12);
    EXPECT_GE(d, to_point - 4.0 / kSteps);
    // Segments that cross in 2D have no common distance to tell.
    if (D == 2 && to_segment < 8.0 / kSteps) continue;
    const double e = std::sqrt(SquaredDistance(a, b, p, q));
    EXPECT_LE(e, to_segment + 1e-12);
    EXPECT_GE(e, to_segment - 8.0 / kSteps);
  }
}
TEST(SegmentDistance, IsTheLeastOfSamplesIn2D) { CompareWithSamples<2>(); }
TEST(SegmentDistance, IsTheLeastOfSamplesIn3D) { CompareWithSamples<3>(); }

TEST(SegmentDistance, SkewLinesAreNearestInside) {
  const Point3 a{{-1, 0, 0}}, b{{1, 0, 0}}, p{{0, -1, 0.25}}, q{{0, 1, 0.25}};
  EXPECT_DOUBLE_EQ(SquaredDistance(a, b, p, q), 0.0625);
}

TEST(MayMeetCube, IsTrueWhereAPlaceOfTheSegmentIsInTheCube) {
  test::Random random(9);
  int met = 0, missed = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto c = RandomPoint<3>(random), p = RandomPoint<3>(random), q = RandomPoint<3>(random);
    const double half = 0.5 * random.Unit();
    double nearest = INFINITY;  // in the norm of the cube
    for (int s = 0; s <= 500; ++s) {
      const auto x = Between(p, q, s / 500.0);
      double d = 0;
      for (int k = 0; k < 3; ++k) d = std::max(d, std::fabs(x[k] - c[k]));
      nearest = std::min(nearest, d);
    }
    if (nearest <= half) {
      EXPECT_TRUE(MayMeetCube(c, half, p, q));
      ++met;
    } else if (nearest > half + 0.01) {
      EXPECT_FALSE(MayMeetCube(c, half, p, q));
      ++missed;
    }
  }
  EXPECT_GT(met, 100);
  EXPECT_GT(missed, 100);
}

}  // namespace
}  // namespace dynmesh::geometry::segment_distance_test
