// What an operation remembers of the region it read: never too small, and not idly large.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/meshing/elements.h"
#include "core/meshing/spatial_tree.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing {
namespace {

using geometry::Point2;

constexpr std::uint64_t kSeed = 20261121;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Balls through p, as those about the corners of its Voronoi cell are.
struct Balls {
  Point2 p;
  std::vector<Point2> centres;
  std::vector<double> radii;
  Extent<2> box = Extent<2>::Nothing();
  double radius2 = 0;

  Balls(test::Random& random, double scale)
      : p{{scale * (random.Unit() - 0.5), scale * (random.Unit() - 0.5)}} {
    const double size = std::ldexp(scale, -random.Below(15));
    for (int n = 1 + random.Below(7); n > 0; --n) {
      const double angle = 2 * std::numbers::pi * random.Unit();
      const double r = size * std::ldexp(random.Unit(), -random.Below(6));
      centres.push_back({{p[0] + r * std::cos(angle), p[1] + r * std::sin(angle)}});
      radii.push_back(r);
      box.AddBall(centres.back(), r);
      radius2 = std::max(radius2, 4 * r * r);
    }
  }
  Payload<2> Region() const {
    Payload<2> payload;
    payload.SetRegion(p, {box.lo}, {box.hi}, radius2);
    return payload;
  }
};

TEST(Payload, RegionHoldsEveryPointOfItsBalls) {
  test::Random random(kSeed);
  for (int round = 0; round < 20000; ++round) {
    const Balls balls(random, std::ldexp(1.0, random.Below(60) - 30));
    const Payload<2> payload = balls.Region();
    for (std::size_t i = 0; i < balls.centres.size(); ++i) {
      // Nearly out on the ball, in the directions where boxes end and in any other.
      const int turn = random.Below(8);
      const double angle = turn < 4 ? turn * std::numbers::pi / 2 : 7 * random.Unit();
      const double r = balls.radii[i] * (1 - 1e-7);
      const Point2 y{
          {balls.centres[i][0] + r * std::cos(angle), balls.centres[i][1] + r * std::sin(angle)}};
      ASSERT_TRUE(payload.RegionMayHold(balls.p, y)) << "seed " << kSeed << ", round " << round;
    }
  }
}

TEST(Payload, RegionIsHardlyLargerThanItsBox) {
  test::Random random(kSeed);
  for (int round = 0; round < 20000; ++round) {
    const Balls balls(random, 1);
    const Payload<2> payload = balls.Region();
    const double slack = std::sqrt(balls.radius2) * (1.0 / 63 + 1e-5);
    const Extent<2>& box = balls.box;
    for (const Point2& y :
         {Point2{{box.hi[0] + slack, balls.p[1]}}, Point2{{box.lo[0] - slack, balls.p[1]}},
          Point2{{balls.p[0], box.hi[1] + slack}}, Point2{{balls.p[0], box.lo[1] - slack}}}) {
      ASSERT_FALSE(payload.RegionMayHold(balls.p, y)) << "seed " << kSeed << ", round " << round;
    }
  }
}

TEST(Payload, RegionMayBeUnbounded) {
  Payload<2> payload;
  payload.SetRegion({{1, 2}}, {{-kInfinity, -kInfinity}}, {{kInfinity, kInfinity}}, 4);
  EXPECT_TRUE(payload.RegionMayHold({{1, 2}}, {{2.9, 2}}));
  EXPECT_TRUE(payload.RegionMayHold({{1, 2}}, {{1, 0.1}}));
  EXPECT_FALSE(payload.RegionMayHold({{1, 2}}, {{3.1, 2}}));
  // A squared radius beyond what a float holds.
  payload.SetRegion({{1, 2}}, {{-1e20, -1e20}}, {{1e20, 1e20}}, 1e40);
  for (const Point2& y : {Point2{{1e19, 2}}, Point2{{-1e19, 1e19}}, Point2{{1, 2}}}) {
    EXPECT_TRUE(payload.RegionMayHold({{1, 2}}, y));
  }
  payload.SetRegion({{1, 2}}, {{1, 2}}, {{3, 2}}, INFINITY);
  EXPECT_TRUE(payload.RegionMayHold({{1, 2}}, {{0.5, 1}}));
}

// There is one of these for each operation, and that is to be a cache line.
static_assert(sizeof(Payload<2>) == 8);

}  // namespace
}  // namespace dynmesh::meshing
