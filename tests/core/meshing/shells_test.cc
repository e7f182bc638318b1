// Small angles: sharp ends, the point where a segment changes its apex, and agreement of the shells
// of two segments.
#include "core/meshing/shells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::shells_test {
namespace {

using geometry::Point2;
using geometry::Point3;

constexpr std::uint64_t kSeed = 20261121;

Point2 Polar(const Point2& apex, double degrees, double r) {
  const double a = degrees * std::numbers::pi / 180;
  return {{apex[0] + r * std::cos(a), apex[1] + r * std::sin(a)}};
}

TEST(Coarsest, IsTheRoundestNumberInARange) {
  EXPECT_EQ(Coarsest(0.3, 0.6), 0.5);
  EXPECT_EQ(Coarsest(0.5, 0.5), 0.5);
  EXPECT_EQ(Coarsest(0.3, 0.45), 0.375);
  EXPECT_EQ(Coarsest(5, 7), 6);
  EXPECT_EQ(Coarsest(0.1, 0.1), 0.1);
  EXPECT_EQ(Coarsest(0.5, 0.75), 0.5);
  EXPECT_EQ(Coarsest(0.4, 1), 1);
  EXPECT_EQ(Coarsest(0.4, 5), 4);
  EXPECT_EQ(Coarsest(0x1p-1000, 0x1.8p-1000), 0x1p-1000);
  EXPECT_EQ(Coarsest(0x1.01p-1000, 0x1.8p-1000), 0x1.8p-1000);
  test::Random random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    const double lo = std::ldexp(0.5 + random.Unit(), random.Below(80) - 40);
    const double hi = lo * (1 + std::ldexp(random.Unit(), -random.Below(20)));
    const double c = Coarsest(lo, hi);
    ASSERT_TRUE(lo <= c && c <= hi) << lo << " " << hi;
    // Nothing in the range is a multiple of a greater power of two.
    double unit = 1;
    while (std::fmod(c, unit) != 0) unit /= 2;
    while (std::fmod(c, 2 * unit) == 0) unit *= 2;
    ASSERT_GT(std::ceil(lo / (2 * unit)) * (2 * unit), hi) << lo << " " << hi;
  }
}

TEST(IsSmallAngle, DrawsTheLineAt60DegreesLessAHair) {
  const Point2 o{{0.3, 0.7}};
  for (const double turn : {0.0, 13.0, 90.0, 271.0}) {
    const auto small = [&](double degrees) {
      const Point2 p = Polar(o, turn, 0.25), q = Polar(o, turn + degrees, 0.5);
      EXPECT_EQ(IsSmallAngle(o, p, q), IsSmallAngle(o, q, p));
      return IsSmallAngle(o, p, q);
    };
    for (const double degrees : {0.001, 1.0, 30.0, 45.0, 59.0, 59.99, -59.0, -0.001}) {
      EXPECT_TRUE(small(degrees)) << degrees;
    }
    for (const double degrees : {60.0, 60.01, 90.0, 120.0, 180.0, -60.0, -100.0}) {
      EXPECT_FALSE(small(degrees)) << degrees;
    }
  }
}

// Against all pairs: a slow, obvious search for the least angle.
TEST(FindWedges, LooksAtTheNeighboursInAngle) {
  test::Random random(kSeed);
  for (int round = 0; round < 300; ++round) {
    const Point2 o{{random.Unit(), random.Unit()}};
    std::vector<double> angles;
    std::vector<Point2> others;
    const int n = 1 + random.Below(12);
    for (int i = 0; i < n; ++i) {
      angles.push_back(360 * random.Unit());
      others.push_back(Polar(o, angles.back(), 0.1 + random.Unit()));
    }
    const auto ends = FindWedges<2>(o, others);
    ASSERT_EQ(ends.size(), others.size());
    for (int i = 0; i < n; ++i) {
      double least = 360;
      for (int j = 0; j < n; ++j) {
        if (j == i) continue;
        const double d = std::fabs(angles[i] - angles[j]);
        least = std::min({least, d, 360 - d});
      }
      if (std::fabs(least - 60) < 1e-3) continue;
      EXPECT_EQ(ends[i].acute, least < 60) << "seed " << kSeed << ", round " << round;
      if (least < 60) {
        EXPECT_NEAR(ends[i].sine, std::sin(least * std::numbers::pi / 180), 1e-9);
        EXPECT_GT(ends[i].reach, 0);
        EXPECT_LE(ends[i].reach, LengthOf(o, others[i]));
      }
    }
    // Whatever order they come in.
    std::vector<Point2> turned(others.rbegin(), others.rend());
    auto again = FindWedges<2>(o, turned);
    std::reverse(again.begin(), again.end());
    EXPECT_EQ(again, ends);
  }
}

// In space all segments within 60 degrees count, not the next ones alone.
TEST(FindWedges, LooksAtAllSegmentsNearbyInSpace) {
  test::Random random(kSeed);
  for (int round = 0; round < 200; ++round) {
    const Point3 o{{random.Unit(), random.Unit(), random.Unit()}};
    std::vector<Point3> others;
    const int n = 1 + random.Below(9);
    for (int i = 0; i < n; ++i) {
      const double height = 2 * random.Unit() - 1, turn = 2 * std::numbers::pi * random.Unit();
      const double length = 0.1 + random.Unit(), r = length * std::sqrt(1 - height * height);
      others.push_back(
          {{o[0] + r * std::cos(turn), o[1] + r * std::sin(turn), o[2] + length * height}});
    }
    const auto ends = FindWedges<3>(o, others);
    ASSERT_EQ(ends.size(), others.size());
    for (int i = 0; i < n; ++i) {
      double least = 180, reach = 0;
      for (int j = 0; j < n; ++j) {
        if (j == i) continue;
        const double a = LengthOf(o, others[i]), b = LengthOf(o, others[j]),
                     c = LengthOf(others[i], others[j]);
        const double cosine = (a * a + b * b - c * c) / (2 * a * b);
        const double degrees = std::acos(cosine) * 180 / std::numbers::pi;
        least = std::min(least, degrees);
        if (degrees < 60) reach = std::max(reach, std::min(a, b * cosine));
      }
      if (std::fabs(least - 60) < 1e-3) continue;
      EXPECT_EQ(ends[i].acute, least < 60) << "seed " << kSeed << ", round " << round;
      if (least >= 60) continue;
      EXPECT_NEAR(ends[i].sine, std::sin(least * std::numbers::pi / 180), 1e-7);
      EXPECT_NEAR(ends[i].reach, reach, 1e-7);
    }
    std::vector<Point3> turned(others.rbegin(), others.rend());
    auto again = FindWedges<3>(o, turned);
    std::reverse(again.begin(), again.end());
    EXPECT_EQ(again, ends);
  }
}

TEST(ShapeOf, HandsOverInTheInside) {
  test::Random random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    const double length = std::ldexp(1 + random.Unit(), random.Below(20) - 10);
    const auto end = [&] {
      const double sine = std::sin(std::numbers::pi / 3 * std::ldexp(1.0, -random.Below(15)));
      return WedgeEnd{true, sine, random.OneIn(3) ? length : length * random.Unit()};
    };
    for (const SegmentShape shape :
         {ShapeOf<2>(length, end(), end()), ShapeOf<3>(length, end(), end())}) {
      ASSERT_GT(shape.handover, 0);
      ASSERT_LT(shape.handover, length);
    }
  }
  EXPECT_EQ(ShapeOf<2>(1, {true, 0.5, 0.5}, {}), (SegmentShape{true, false, 0}));
  // The diagonal of a square: half of it in 3D.
  const WedgeEnd diagonal = {true, std::sqrt(0.5), 0.5};
  EXPECT_NE(ShapeOf<2>(1, diagonal, diagonal).handover, 0.5);
  EXPECT_EQ(ShapeOf<3>(1, diagonal, diagonal).handover, 0.5);
}

// Split at random until subsegments are short: the shells of the shorter one are among those of
// the longer, and none is finer than the subsegments ask for.
TEST(RulesOfParts, ShellsAgreeAndStayCoarse) {
  test::Random random(kSeed);
  for (int round = 0; round < 200; ++round) {
    const double length = 0.2 + random.Unit();
    std::vector<SplitRule> subsegments = {SplitRule::Whole({true, false, 0}, length)};
    const double least = std::ldexp(length, -random.Below(8) - 1);
    double finest = length;
    for (std::size_t i = 0; i < subsegments.size();) {
      const SplitRule subsegment = subsegments[i];
      const double size = subsegment.at_b - subsegment.at_a;
      ASSERT_GT(size, 0);
      if (size <= least) {
        finest = std::min(finest, size);
        ++i;
        continue;
      }
      const auto [left, right] = RulesOfParts(subsegment, length);
      EXPECT_EQ(left.at_a, subsegment.at_a);
      EXPECT_EQ(left.at_b, right.at_a);
      EXPECT_EQ(right.at_b, subsegment.at_b);
      EXPECT_EQ(left.at_b, SplitDistance(subsegment));
      EXPECT_GE(left.at_b - left.at_a, size / 4);
      EXPECT_GE(right.at_b - right.at_a, size / 4);
      subsegments[i] = left;
      subsegments.push_back(right);
    }
    EXPECT_GE(finest, least / 4);
  }
}

// The vertices of two segments from one apex, on the same shells but for their skews.
TEST(SkewOf, LeavesTheBallsBetweenTwoShellsEmpty) {
  test::Random random(kSeed);
  const auto unit = [&] {
    Point3 u;
    for (int i = 0; i < 3; ++i) u[i] = random.Unit() - 0.5;
    const double length = LengthOf(u, Point3{});
    for (int i = 0; i < 3; ++i) u[i] /= length;
    return u;
  };
  double most = 0;
  for (int round = 0; round < 2000; ++round) {
    const double angle = std::numbers::pi / 3 * std::pow(1.7e-5, random.Unit());
    const Point3 apex{}, u = unit(), w = unit();
    double along = 0;
    for (int i = 0; i < 3; ++i) along += u[i] * w[i];
    std::vector<Point3> ends(2);
    const double across = std::sqrt(1 - along * along);
    for (int i = 0; i < 3; ++i) {
      ends[0][i] = u[i];
      ends[1][i] = std::cos(angle) * u[i] + std::sin(angle) * (w[i] - along * u[i]) / across;
    }
    const std::vector<WedgeEnd> wedges = FindWedges<3>(apex, ends);
    if (!wedges[0].acute) continue;
    // By distance of the shell. Both segments are split alike.
    std::array<std::map<double, Point3>, 2> vertices;
    std::vector<std::pair<double, double>> between;
    for (std::size_t k = 0; k < 2; ++k) {
      const double length = LengthOf(apex, ends[k]);
      const SegmentShape shape = ShapeOf<3>(length, wedges[k], {});
      EXPECT_EQ(shape.skew_at_b, 0);
      std::vector<SplitRule> subsegments = {SplitRule::Whole(shape, length)};
      for (int depth = 0; depth < 6; ++depth) {
        std::vector<SplitRule> parts;
        for (const SplitRule& rule : subsegments) {
          const double at = SplitDistance(rule), skew = SkewOf(rule, apex, ends[k], length);
          EXPECT_LE(std::fabs(skew), std::ldexp(at, -18));
          EXPECT_LE(std::fabs(skew), std::ldexp(rule.at_b - rule.at_a, -20));
          most = std::max(most, std::fabs(skew) / (rule.at_b - rule.at_a));
          vertices[k][at] = PointAt(apex, ends[k], length, at + skew);
          for (const SplitRule& part : RulesOfParts(rule, length)) parts.push_back(part);
        }
        subsegments = parts;
      }
    }
    for (std::size_t k = 0; k < 2; ++k) {
      for (auto far = std::next(vertices[k].begin()); far != vertices[k].end(); ++far) {
        const auto near = std::prev(far);
        for (const double shell : {near->first, far->first}) {
          const auto other = vertices[1 - k].find(shell);
          if (other == vertices[1 - k].end()) continue;
          double dot = 0;
          for (int i = 0; i < 3; ++i) {
            dot += (near->second[i] - other->second[i]) * (far->second[i] - other->second[i]);
          }
          EXPECT_GT(dot, 0) << "seed " << kSeed << ", round " << round << ", " << angle;
        }
      }
    }
  }
  EXPECT_GT(most, 0x1p-21);  // there are some
}

TEST(SkewOf, IsTheSameOnParallelEdgesAndDiffersInAFan) {
  test::Random random(kSeed);
  SplitRule rule = SplitRule::Whole({true, false, 0, 20, 0}, 1);
  EXPECT_EQ(SkewOf(rule, Point2{}, Point2{{1, 0}}, 1), 0);  // in the plane there is none
  const auto at = [&](const Point3& apex, double turn) {
    return SkewOf(rule, apex, Point3{{apex[0] + std::cos(turn), apex[1], apex[2] + std::sin(turn)}},
                  1);
  };
  int near = 0;
  for (int round = 0; round < 1000; ++round) {
    const double turn = 2 * std::numbers::pi * random.Unit();
    const Point3 low{{random.Unit(), random.Unit(), random.Unit()}};
    const Point3 high{{low[0] + random.Unit(), low[1], low[2] + random.Unit()}};
    const double skew = at(low, turn);
    // As near as the rounding of coordinates allows.
    EXPECT_NEAR(at(high, turn), skew, 0x1p-52) << "seed " << kSeed << ", round " << round;
    near += std::fabs(at(low, turn + std::numbers::pi / 180) - skew) < 0x1p-27;
  }
  EXPECT_LT(near, 50);
}

TEST(SplitRule, OfASegmentSharpAtBothEndsIsHandedOverFirst) {
  const SplitRule whole = SplitRule::Whole({true, true, 0.375}, 1.0);
  EXPECT_EQ(SplitDistance(whole), 0.375);
  const auto [a, b] = RulesOfParts(whole, 1.0);
  EXPECT_EQ(a.kind, SplitRule::Kind::kShells);
  EXPECT_FALSE(a.from_b);
  EXPECT_EQ(a.at_b, 0.375);
  EXPECT_TRUE(b.from_b);
  EXPECT_EQ(b.at_a, 0.625);
  EXPECT_EQ(b.at_b, 0);
  EXPECT_EQ(SplitRule::Whole({}, 1.0).kind, SplitRule::Kind::kHalve);
}

}  // namespace
}  // namespace dynmesh::meshing::shells_test
