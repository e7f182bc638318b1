// The rules for pairs: exact where they are exact, symmetric everywhere.
#include "core/plc/rules.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc::rules_test {
namespace {

using geometry::Point2;

constexpr double kLimit = 0x1p-41;

SegmentFeature<2> Segment(FeatureId id, FeatureId p_id, FeatureId q_id, Point2 p, Point2 q) {
  return {id, p_id, q_id, p, q};
}
SegmentFeature<2> Reversed(const SegmentFeature<2>& s) { return {s.id, s.q_id, s.p_id, s.q, s.p}; }

// All eight argument orders must agree.
Conflict Ask(const SegmentFeature<2>& s, const SegmentFeature<2>& t) {
  const Conflict answer = Between(s, t, kLimit);
  for (const SegmentFeature<2>& a : {s, Reversed(s)}) {
    for (const SegmentFeature<2>& b : {t, Reversed(t)}) {
      EXPECT_EQ(Between(a, b, kLimit), answer);
      EXPECT_EQ(Between(b, a, kLimit), answer);
    }
  }
  return answer;
}

TEST(Rules, TheCloseLimitIsThePowerOfTwoAt1024Ulps) {
  EXPECT_EQ(CloseLimit(Square(0, 1)), 0x1p-41);
  EXPECT_EQ(CloseLimit(Square(0, 1024)), 0x1p-31);
  EXPECT_EQ(CloseLimit(Square(1024, 1025)), 0x1p-32);
  EXPECT_EQ(CloseLimit(Square(-1025, -1024)), 0x1p-32);
}

TEST(Rules, SegmentsApart) {
  const SegmentFeature<2> s = Segment(9, 1, 2, {{0, 0}}, {{1, 0}});
  const auto with = [&](Point2 c, Point2 d) { return Ask(s, Segment(10, 3, 4, c, d)); };
  EXPECT_EQ(with({{0.5, -1}}, {{0.5, 1}}), Conflict::kSegmentsCross);
  EXPECT_EQ(with({{0.5, 0x1p-52}}, {{0.5, 1}}), Conflict::kNone);
  EXPECT_EQ(with({{1 + 0x1p-52, -1}}, {{1 + 0x1p-52, 1}}), Conflict::kNone);
  EXPECT_EQ(with({{0.5, 0}}, {{0.5, 1}}), Conflict::kNone);  // the point's rule reports it
  EXPECT_EQ(with({{0.5, 0}}, {{2, 0}}), Conflict::kSegmentsOverlap);
  EXPECT_EQ(with({{-1, 0}}, {{2, 0}}), Conflict::kSegmentsOverlap);
  EXPECT_EQ(with({{0.25, 0}}, {{0.5, 0}}), Conflict::kSegmentsOverlap);
  EXPECT_EQ(with({{2, 0}}, {{3, 0}}), Conflict::kNone);
  EXPECT_EQ(with({{0, 1}}, {{1, 1}}), Conflict::kNone);
}

TEST(Rules, SegmentsThatShareAnEnd) {
  const SegmentFeature<2> s = Segment(9, 1, 2, {{0, 0}}, {{1, 0}});
  const auto with = [&](Point2 d) { return Ask(s, Segment(10, 1, 3, {{0, 0}}, d)); };
  const double least = std::tan(std::numbers::pi / 180'000);  // 0.001 degrees
  EXPECT_EQ(with({{1, 1}}), Conflict::kNone);
  EXPECT_EQ(with({{1, least}}), Conflict::kNone);
  EXPECT_EQ(with({{1, -least}}), Conflict::kNone);
  EXPECT_EQ(with({{1, least * (1 - 1e-7)}}), Conflict::kNone);        // within the margin
  EXPECT_EQ(with({{1, least * (1 - 2e-6)}}), Conflict::kSmallAngle);  // outside it
  EXPECT_EQ(with({{1, -least * (1 - 2e-6)}}), Conflict::kSmallAngle);
  EXPECT_EQ(with({{1, 0x1p-52}}), Conflict::kSmallAngle);
  EXPECT_EQ(with({{2, 0}}), Conflict::kSegmentsOverlap);
  EXPECT_EQ(with({{0.5, 0}}), Conflict::kSegmentsOverlap);
  EXPECT_EQ(with({{-1, 0}}), Conflict::kNone);
  EXPECT_EQ(with({{-1, 0x1p-52}}), Conflict::kNone);
  EXPECT_EQ(with({{0, 1}}), Conflict::kNone);
  EXPECT_EQ(Ask(s, Segment(10, 2, 1, {{1, 0}}, {{0, 0}})), Conflict::kDuplicateSegment);
}

TEST(Rules, PointsAndSegments) {
  const SegmentFeature<2> s = Segment(9, 1, 2, {{0.25, 0.25}}, {{0.75, 0.5}});
  const auto with = [&](Point2 x) {
    const Conflict answer = Between(PointFeature<2>{3, x}, s, kLimit);
    EXPECT_EQ(Between(PointFeature<2>{3, x}, Reversed(s), kLimit), answer);
    return answer;
  };
  EXPECT_EQ(with({{0.5, 0.375}}), Conflict::kPointOnSegment);
  EXPECT_EQ(with({{0.5, 0.375 + 0x1p-54}}), Conflict::kTooClose);
  EXPECT_EQ(with({{0.5, 0.375 - 0x1p-54}}), Conflict::kTooClose);
  EXPECT_EQ(with({{1.0, 0.625}}), Conflict::kNone);  // on the line, off the segment
  EXPECT_EQ(with({{0.75 + 0x1p-42, 0.5}}), Conflict::kTooClose);
  EXPECT_EQ(with({{0.75 + 0x1p-41, 0.5}}), Conflict::kNone);
  EXPECT_EQ(Between(PointFeature<2>{1, {{0.25, 0.25}}}, s, kLimit), Conflict::kNone);  // its end
}

TEST(Rules, NearnessIsTheSameFromBothEndsToTheBit) {
  const unsigned seed = 4711;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int near = 0;
  for (int i = 0; i < 100000; ++i) {
    const Point2 a{{unit(random), unit(random)}}, b{{unit(random), unit(random)}};
    const double t = unit(random) * 1.2 - 0.1, off = (unit(random) - 0.5) * 4 * kLimit;
    const Point2 x{{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]) + off}};
    const bool answer = IsNear(x, a, b, kLimit);
    ASSERT_EQ(IsNear(x, b, a, kLimit), answer) << "seed " << seed << ", try " << i;
    near += answer ? 1 : 0;
  }
  EXPECT_GT(near, 10000);
  EXPECT_LT(near, 90000);
}

}  // namespace
}  // namespace dynmesh::plc::rules_test
