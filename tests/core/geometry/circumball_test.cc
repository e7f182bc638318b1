// Balls through four points, in doubles and by integers, beside exact rationals.
#include "core/geometry/circumball.h"

#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/geometry/exact_integer.h"
#include "core/geometry/space_predicates.h"
#include "tests/support/seed.h"

namespace dynmesh::geometry::circumball_test {
namespace {

using Exact = CGAL::Simple_cartesian<CGAL::Exact_rational>;

Exact::Point_3 Of(const Point3& p) { return {p[0], p[1], p[2]}; }

// The centre, seen from p.
Vector3 CentreByRationals(const Point3& p, const Point3& a, const Point3& b, const Point3& c) {
  const Exact::Vector_3 w = CGAL::circumcenter(Of(p), Of(a), Of(b), Of(c)) - Of(p);
  return {CGAL::to_double(w.x()), CGAL::to_double(w.y()), CGAL::to_double(w.z())};
}

// Any four points; or nearly flat, four nearly on a circle.
std::array<Point3, 4> AnyPoints(std::mt19937_64& random, bool flat) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const double scale = std::exp2(static_cast<int>(random() % 60) - 30);
  std::array<Point3, 4> p;
  for (Point3& q : p) {
    for (int k = 0; k < 3; ++k) q[k] = unit(random);
    if (flat) {
      const double turn = 3 * unit(random);
      const double grain = std::exp2(-static_cast<int>(random() % 50));
      q = {{0.3 + std::cos(turn), 0.6 * std::sin(turn) + grain * unit(random),
            0.8 * std::sin(turn)}};
    }
    for (int k = 0; k < 3; ++k) q[k] *= scale;
  }
  return p;
}

class CircumballTest : public ::testing::TestWithParam<bool> {};

TEST_P(CircumballTest, IsAsNearAsItSays) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  int known = 0, unknown = 0;
  for (int i = 0; i < 3000; ++i) {
    auto [p, a, b, c] = AnyPoints(random, GetParam());
    const int side = Orientation(p, a, b, c);
    if (side == 0) continue;
    if (side < 0) std::swap(b, c);
    const Vector3 truth = CentreByRationals(p, a, b, c);
    const double size = std::sqrt(Dot(truth, truth));
    const Circumball exact = ExactCircumball(p, a, b, c);
    const Vector3 da = Difference(a.c, p.c), db = Difference(b.c, p.c), dc = Difference(c.c, p.c);
    const Circumball ball(da, Dot(da, da), db, Dot(db, db), dc, Dot(dc, dc), false);
    for (int k = 0; k < 3; ++k) {
      ASSERT_NEAR(exact.w[k], truth[k], 1e-14 * size) << i;
      ASSERT_LE(std::fabs(exact.w[k] - truth[k]), exact.error + 1e-15 * size);
      ASSERT_LE(std::fabs(ball.w[k] - truth[k]), ball.error + 1e-15 * size) << i;
    }
    ++(ball.error < 1e-6 * size ? known : unknown);
  }
  EXPECT_GT(known, 100);
  if (GetParam()) {
    EXPECT_GT(unknown, 100);
  }
}

INSTANTIATE_TEST_SUITE_P(FlatOrNot, CircumballTest, ::testing::Bool());

TEST(Circumball, OfFourCoplanarPointsIsNotKnown) {
  const Point3 p{{0, 0, 0}}, a{{1, 0, 0}}, b{{0, 1, 0}}, c{{1, 1, 0}};
  EXPECT_EQ(ExactCircumball(p, a, b, c).r2, INFINITY);
  EXPECT_EQ(Circumball(a.c, 1, b.c, 1, c.c, 2, false).r2, INFINITY);
}

TEST(ScaledDouble, IsTheNumberToTheLastBitButOne) {
  EXPECT_EQ(ToScaledDouble(ToInteger<2>(0, 0)).mantissa, 0);
  for (const double x : {1.0, -1.0, 3.0, -1e15, 123456789.0, 0x1p90, -0x1.8p100}) {
    const auto s = ToScaledDouble(ToInteger<2>(x, 0));
    EXPECT_EQ(std::ldexp(s.mantissa, s.exponent), x);
    EXPECT_LE(1, std::fabs(s.mantissa));
    EXPECT_LT(std::fabs(s.mantissa), 2);
  }
}

}  // namespace
}  // namespace dynmesh::geometry::circumball_test
