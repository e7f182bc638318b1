// The numbers of refinement, against exact rationals and against their purpose.
#include <CGAL/Exact_rational.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>

#include "core/base/rounding.h"
#include "core/meshing/planar_rules.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::rules_test {
namespace {

using Exact = CGAL::Exact_rational;
using geometry::Point2;

constexpr double kQualities[] = {100, 2, kDefaultQuality2D, 1.2, 1};

MeshOptions WithQuality(double quality) {
  MeshOptions options;
  options.quality = quality;
  return options;
}

struct ExactCorner {
  Exact px, py, qx, qy;  // from c
  ExactCorner(const Point2& p, const Point2& q, const Point2& c)
      : px(Exact(p[0]) - c[0]),
        py(Exact(p[1]) - c[1]),
        qx(Exact(q[0]) - c[0]),
        qy(Exact(q[1]) - c[1]) {}
  Exact dot() const { return px * qx + py * qy; }
  // (R / |pq|)^2 = |pc|^2 |qc|^2 / (2 cross)^2.
  Exact Ratio2() const {
    const Exact cross = px * qy - py * qx;
    return (px * px + py * py) * (qx * qx + qy * qy) / (4 * cross * cross);
  }
};

// (R/e)^2 at which a triangle of sides e, sqrt(B) e, sqrt(B) e has R = rho e: then
// B^2 = 4 rho^2 (B - 1/4).
Exact OffCenterB(double quality) {
  const double rho2 = quality * quality;
  return Exact(2 * rho2 + std::sqrt(4 * rho2 * rho2 - rho2));
}

// An edge at random and a third point at its left, so that the circumcircle has radius
// `ratio` times the edge and its centre is at the left.
struct Corner {
  Point2 p, q, c;
};
Corner RandomCorner(test::Random& random, double ratio) {
  const double e = std::ldexp(1.0, -random.Below(25));
  const double turn = 2 * std::numbers::pi * random.Unit();
  const Point2 p = {{random.Unit(), random.Unit()}};
  const Point2 q = {{p[0] + e * std::cos(turn), p[1] + e * std::sin(turn)}};
  const double height = e * std::sqrt(ratio * ratio - 0.25);
  const Point2 o = {
      {(p[0] + q[0]) / 2 - height * std::sin(turn), (p[1] + q[1]) / 2 + height * std::cos(turn)}};
  // On the arc at the left of pq.
  const double open = std::asin(0.5 / ratio);
  const double at =
      turn + std::numbers::pi / 2 + (std::numbers::pi - open) * (0.98 * (2 * random.Unit() - 1));
  return {p, q, {{o[0] + ratio * e * std::cos(at), o[1] + ratio * e * std::sin(at)}}};
}

double SquaredLength(const Point2& p, const Point2& q) { return geometry::SquaredDistance(p, q); }

TEST(Rules, GapAtIsTheExactTestOfTheTriangleBeyondTheEdge) {
  const std::uint64_t seed = 31;
  test::Random random(seed);
  std::map<Gap, int> seen;
  int close = 0;
  for (const double quality : kQualities) {
    const PlanarRules rules(WithQuality(quality));
    const Exact b = OffCenterB(quality);
    for (int i = 0; i < 4000; ++i) {
      // Around the two thresholds, near and far, and anything.
      const double nearness = std::ldexp(random.Unit() - 0.5, -random.Below(45));
      const double at = random.OneIn(2) ? quality * (1 + 2e-9) : std::sqrt(CGAL::to_double(b));
      const double ratio =
          random.OneIn(4) ? 0.5 + 3 * quality * random.Unit() : at * (1 + nearness);
      auto [p, q, c] = RandomCorner(random, std::max(ratio, 0.5000001));
      if (random.OneIn(8)) c = {{random.Unit(), random.Unit()}};
      const double cross = (p[0] - c[0]) * (q[1] - c[1]) - (p[1] - c[1]) * (q[0] - c[0]);
      if (!(cross > 0)) continue;
      const double e2 = SquaredLength(p, q);
      const double slack = QualitySlackAt(std::ilogb(e2), rules.ulp());
      const ExactCorner exact(p, q, c);
      const Exact r = exact.Ratio2();
      const Exact skinny = Exact(quality) * quality * (1 + Exact(slack)) * (1 + Exact(slack));
      const Gap got = rules.GapAt(p, q, c, BucketOf(e2));
      const Gap wanted = r <= skinny || exact.dot() <= 0 ? Gap::kNone
                         : r > b                         ? Gap::kOffCenter
                                                         : Gap::kCircumcenter;
      ++seen[wanted];
      if (got == wanted) continue;
      // Rounding may decide at a threshold only. Differences of coordinates are off by
      // 2^-53 of themselves, and what they lose in `cross` grows with the flatness.
      const double flat = std::sqrt(CGAL::to_double(r) * 4) / std::fabs(1e-300 + 1);
      const double tolerance = 1e-14 * (1 + flat);
      const auto at_threshold = [&](const Exact& t) {
        return std::fabs(CGAL::to_double(r / t - 1)) < tolerance;
      };
      ++close;
      EXPECT_TRUE(at_threshold(skinny) || at_threshold(b) ||
                  std::fabs(CGAL::to_double(exact.dot())) <
                      1e-14 * std::sqrt(SquaredLength(p, c) * SquaredLength(q, c)))
          << "seed " << seed << " quality " << quality << " try " << i << " ratio " << ratio
          << ": got " << static_cast<int>(got) << ", exactly " << static_cast<int>(wanted);
    }
  }
  for (const Gap gap : {Gap::kNone, Gap::kCircumcenter, Gap::kOffCenter}) {
    EXPECT_GT(seen[gap], 500) << static_cast<int>(gap);
  }
  EXPECT_LT(close, 200);
}

TEST(Rules, AreSymmetricInTheEndsOfTheEdgeToTheBit) {
  const std::uint64_t seed = 32;
  test::Random random(seed);
  for (const double quality : kQualities) {
    const PlanarRules rules(WithQuality(quality));
    const double off = std::sqrt(CGAL::to_double(OffCenterB(quality)));
    for (int i = 0; i < 20000; ++i) {
      const double nearness = std::ldexp(random.Unit() - 0.5, -20 - random.Below(33));
      const double at = random.OneIn(2) ? quality * (1 + 2e-9) : off;
      const auto [p, q, c] = RandomCorner(random, at * (1 + nearness));
      const int bucket = BucketOf(SquaredLength(p, q));
      ASSERT_EQ(bucket, BucketOf(SquaredLength(q, p)));
      ASSERT_EQ(rules.GapAt(p, q, c, bucket), rules.GapAt(q, p, c, bucket)) << "seed " << seed;
      ASSERT_EQ(rules.BeginsBeyond(p, q, c), rules.BeginsBeyond(q, p, c)) << "seed " << seed;
    }
  }
}

// The Voronoi edge begins at the circumcenter of the triangle on the other side. That is beyond the
// edge if the angle is obtuse.
TEST(Rules, BeginsBeyondIsExactAwayFromTheThreshold) {
  const std::uint64_t seed = 33;
  test::Random random(seed);
  int yes = 0, no = 0;
  for (const double quality : kQualities) {
    const PlanarRules rules(WithQuality(quality));
    const Exact b = OffCenterB(quality);
    for (int i = 0; i < 4000; ++i) {
      // d sees pq at an obtuse angle, or nearly.
      const Point2 p = {{random.Unit(), random.Unit()}}, q = {{random.Unit(), random.Unit()}};
      const double t = random.Unit(), out = std::ldexp(random.Unit(), -random.Below(12));
      const Point2 d = {{p[0] + t * (q[0] - p[0]) + out * (q[1] - p[1]),
                         p[1] + t * (q[1] - p[1]) - out * (q[0] - p[0])}};
      const ExactCorner exact(p, q, d);
      const Exact r = exact.Ratio2();
      const double away = std::fabs(CGAL::to_double(r / b - 1));
      if (away < 1e-9 || std::fabs(CGAL::to_double(exact.dot())) < 1e-12) continue;
      const bool wanted = exact.dot() < 0 && r > b;
      ++(wanted ? yes : no);
      ASSERT_EQ(rules.BeginsBeyond(p, q, d), wanted) << "seed " << seed << " try " << i;
    }
  }
  EXPECT_GT(yes, 1000);
  EXPECT_GT(no, 1000);
}

// Its triangle is just good enough: R = rho e.
TEST(Rules, OffCenterMakesATriangleOfTheQualityAskedFor) {
  const std::uint64_t seed = 34;
  test::Random random(seed);
  for (const double quality : kQualities) {
    const PlanarRules rules(WithQuality(quality));
    const double far = std::sqrt(CGAL::to_double(OffCenterB(quality)));
    for (int i = 0; i < 1000; ++i) {
      const auto [p, q, unused] = RandomCorner(random, 1);
      const Point2 x = rules.OffCenter(p, q);
      const double e = std::sqrt(SquaredLength(p, q));
      const double rounding = 1e-12 + 4 * std::numeric_limits<double>::epsilon() / e;
      EXPECT_NEAR(std::sqrt(SquaredLength(x, p)) / e, far, far * rounding);
      EXPECT_NEAR(std::sqrt(SquaredLength(x, q)) / e, far, far * rounding);
      EXPECT_GT((p[0] - x[0]) * (q[1] - x[1]) - (p[1] - x[1]) * (q[0] - x[0]), 0) << "at its left";
      const double ratio = std::sqrt(CGAL::to_double(ExactCorner(p, q, x).Ratio2()));
      EXPECT_NEAR(ratio, quality, quality * 20 * rounding) << "seed " << seed << " try " << i;
    }
  }
}

TEST(Buckets, AreMonotoneAndNarrow) {
  const std::uint64_t seed = 35;
  test::Random random(seed);
  const auto any = [&] { return std::ldexp(1 + random.Unit(), random.Below(2000) - 1010); };
  for (int i = 0; i < 100000; ++i) {
    const double x = any();
    const double y = random.OneIn(2) ? any() : std::nextafter(x, INFINITY);
    ASSERT_EQ(BucketOf(x) < BucketOf(y), BucketOf(x) != BucketOf(y) && x < y) << x << " " << y;
    const int b = BucketOf(x);
    ASSERT_GE(x, LeastOfBucket(b));
    ASSERT_LT(x, LeastOfBucket(b + 1));
    ASSERT_LE(LeastOfBucket(b + 1), 1.25 * LeastOfBucket(b));  // sqrt(1.25) in length
  }
  EXPECT_EQ(BucketOf(0), 0);
  EXPECT_LT(BucketOf(std::numeric_limits<double>::max()), kBuckets);
  for (int b = 0; b + 1 < BucketOf(INFINITY); ++b) {
    ASSERT_LT(LeastOfBucket(b), LeastOfBucket(b + 1));
    ASSERT_EQ(BucketOf(LeastOfBucket(b)), b);
  }
}

// A decision about an edge depends on nothing farther than its off-center.
TEST(Rules, ReachIsBeyondTheOffCenterOfEveryEdgeThatIsJudgedWithIt) {
  for (const double quality : kQualities) {
    const PlanarRules rules(WithQuality(quality));
    const double far = std::sqrt(CGAL::to_double(OffCenterB(quality)));
    for (int b = BucketOf(0x1p-200); b < BucketOf(0x1p200); ++b) {
      const double longest =
          std::sqrt(std::nextafter(LeastOfBucket(rules.LastKnownBucket(b) + 1), 0));
      ASSERT_GE(rules.LastKnownBucket(b), b);
      ASSERT_GT(rules.Reach(b), far * longest * (1 + 1e-9)) << "quality " << quality;
      ASSERT_LT(rules.Reach(b), far * longest * 1.01) << "no farther than needed";
    }
  }
}

}  // namespace
}  // namespace dynmesh::meshing::rules_test
