// The exact predicates: against rational arithmetic, and by their algebraic laws.
#include "core/geometry/predicates.h"

#include <CGAL/Exact_rational.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <optional>

#include "tests/core/geometry/random_points.h"

namespace dynmesh::geometry::predicates_test {
namespace {

using testing::kAllKinds;
using testing::Kind;
using testing::NewSeed;
using testing::PointSource;
using Q = CGAL::Exact_rational;

int SignOf(const Q& q) { return q > 0 ? 1 : q < 0 ? -1 : 0; }
Q X(const Point2& p) { return Q(p[0]); }
Q Y(const Point2& p) { return Q(p[1]); }
Q SlowCross(const Point2& o, const Point2& a, const Point2& b) {
  return (X(a) - X(o)) * (Y(b) - Y(o)) - (Y(a) - Y(o)) * (X(b) - X(o));
}
Q Square(const Point2& o, const Point2& a) {
  const Q x = X(a) - X(o), y = Y(a) - Y(o);
  return x * x + y * y;
}
// The ladder of InCircle without its perturbation.
int InCircleSign(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const int sign = internal::InCircleFilter(a, b, c, d);
  return sign != internal::kUnsure ? sign : internal::InCircleExact(a, b, c, d);
}
int SlowOrientation(const Point2& a, const Point2& b, const Point2& c) {
  return SignOf(SlowCross(a, b, c));
}
int SlowInCircle(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  return SignOf(Square(d, a) * SlowCross(d, b, c) - Square(d, b) * SlowCross(d, a, c) +
                Square(d, c) * SlowCross(d, a, b));
}
int SlowDiametral(const Point2& a, const Point2& b, const Point2& x) {
  return SignOf((X(a) - X(x)) * (X(b) - X(x)) + (Y(a) - Y(x)) * (Y(b) - Y(x)));
}

class PredicatesOn : public ::testing::TestWithParam<Kind> {
 protected:
  PredicatesOn() : seed_(NewSeed()), source_(GetParam(), seed_) {}
  std::string Trace() const { return "seed " + std::to_string(seed_); }

  std::uint64_t seed_;
  PointSource<2> source_;
  static constexpr int kRounds = 20000;
};

TEST_P(PredicatesOn, AllSignsAgreeWithRationals) {
  SCOPED_TRACE(Trace());
  for (int i = 0; i < kRounds; ++i) {
    const Point2 a = source_.Next(), b = source_.Next(), c = source_.Next(), d = source_.Next();
    ASSERT_EQ(Orientation(a, b, c), SlowOrientation(a, b, c)) << "round " << i;
    ASSERT_EQ(InCircleSign(a, b, c, d), SlowInCircle(a, b, c, d)) << "round " << i;
    ASSERT_EQ(InDiametralBall(a, b, c), SlowDiametral(a, b, c) < 0) << "round " << i;
  }
}

TEST_P(PredicatesOn, FiltersNeverContradictTheExactRung) {
  SCOPED_TRACE(Trace());
  for (int i = 0; i < kRounds; ++i) {
    const Point2 a = source_.Next(), b = source_.Next(), c = source_.Next(), d = source_.Next();
    const auto expect = [&](int filtered, int exact) {
      ASSERT_TRUE(filtered == internal::kUnsure || filtered == exact) << "round " << i;
    };
    expect(internal::OrientationFilter(a, b, c), internal::OrientationExact(a, b, c));
    expect(internal::InCircleFilter(a, b, c, d), internal::InCircleExact(a, b, c, d));
    expect(internal::InDiametralBallFilter(a, b, c), internal::InDiametralBallExact(a, b, c));
    ASSERT_EQ(internal::OrientationExact(a, b, c), SlowOrientation(a, b, c));
    ASSERT_EQ(internal::InCircleExact(a, b, c, d), SlowInCircle(a, b, c, d));
  }
}

// Where a horizontal line meets the edge, by rationals.
std::optional<bool> SlowCrossesEdge(const Point2& p, const Point2& a, const Point2& b) {
  const double lo = std::min(a[1], b[1]), hi = std::max(a[1], b[1]);
  const bool is_on = SlowOrientation(a, b, p) == 0 && SlowDiametral(a, b, p) <= 0;
  if (is_on || a == p || b == p) return std::nullopt;
  if (!(lo <= p[1] && p[1] < hi)) return false;
  return X(a) + (Y(p) - Y(a)) * (X(b) - X(a)) / (Y(b) - Y(a)) > X(p);
}

TEST_P(PredicatesOn, CrossesEdgeAgreesWithRationals) {
  SCOPED_TRACE(Trace());
  for (int i = 0; i < kRounds; ++i) {
    const Point2 a = source_.Next(), b = source_.Next(), p = source_.Next();
    const std::optional<bool> crosses = SlowCrossesEdge(p, a, b);
    ASSERT_EQ(CrossesEdge(p, a, b), crosses) << "round " << i;
    ASSERT_EQ(CrossesEdge(p, b, a), crosses) << "round " << i;
    ASSERT_EQ(CrossesEdge(a, a, b), std::nullopt);
  }
}

TEST_P(PredicatesOn, OrientationIsCyclicAndAntisymmetric) {
  SCOPED_TRACE(Trace());
  for (int i = 0; i < kRounds; ++i) {
    const Point2 a = source_.Next(), b = source_.Next(), c = source_.Next();
    const int sign = Orientation(a, b, c);
    ASSERT_EQ(sign, Orientation(b, c, a));
    ASSERT_EQ(sign, Orientation(c, a, b));
    ASSERT_EQ(sign, -Orientation(b, a, c));
    ASSERT_EQ(sign, -Orientation(a, c, b));
    ASSERT_EQ(sign, -Orientation(c, b, a));
    ASSERT_EQ(Orientation(a, a, b), 0);
  }
}

TEST_P(PredicatesOn, InCircleSignIsAlternating) {
  SCOPED_TRACE(Trace());
  for (int i = 0; i < kRounds; ++i) {
    const Point2 a = source_.Next(), b = source_.Next(), c = source_.Next(), d = source_.Next();
    const int sign = InCircleSign(a, b, c, d);
    ASSERT_EQ(sign, InCircleSign(b, c, a, d));
    ASSERT_EQ(sign, -InCircleSign(b, a, c, d));
    ASSERT_EQ(sign, -InCircleSign(a, b, d, c));
    ASSERT_EQ(sign, -InCircleSign(d, b, c, a));
  }
}

TEST_P(PredicatesOn, InCircleNeverTiesAndNamesOneDiagonalOfAConvexQuadrangle) {
  SCOPED_TRACE(Trace());
  int quadrangles = 0;
  for (int i = 0; i < kRounds; ++i) {
    const Point2 a = source_.Next(), b = source_.Next(), c = source_.Next(), d = source_.Next();
    if (Orientation(a, b, c) <= 0 || Orientation(a, c, d) <= 0) continue;
    const bool inside = InCircle(a, b, c, d);
    ASSERT_EQ(inside, InCircle(b, c, a, d));
    ASSERT_EQ(inside, InCircle(c, a, b, d));
    ASSERT_EQ(inside, InCircle(a, c, d, b));  // the same from the triangle beyond ac
    if (const int sign = InCircleSign(a, b, c, d); sign != 0) {
      ASSERT_EQ(inside, sign > 0);
    }
    if (Orientation(a, b, d) <= 0 || Orientation(b, c, d) <= 0) continue;
    ++quadrangles;
    ASSERT_NE(inside, InCircle(a, b, d, c));  // exactly one diagonal is legal
  }
  EXPECT_GT(quadrangles, 100);
}

std::string KindName(const ::testing::TestParamInfo<Kind>& info) {
  static constexpr const char* kNames[] = {"Uniform",    "Grid", "BigGrid", "Native",
                                           "Cocircular", "Ulps", "Scales",  "WildExponents"};
  return kNames[static_cast<int>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(Predicates, PredicatesOn, ::testing::ValuesIn(kAllKinds), KindName);

TEST(Predicates, OrientationSeesOneUlpOffALine) {
  const Point2 a{{0.5, 0.5}}, b{{12, 12}};
  EXPECT_EQ(Orientation(a, b, {{24, 24}}), 0);
  EXPECT_EQ(Orientation(a, b, {{24, std::nextafter(24, 25)}}), 1);
  EXPECT_EQ(Orientation(a, b, {{24, std::nextafter(24, 23)}}), -1);
}

TEST(Predicates, DecideAtBothEndsOfTheDomain) {
  for (const double s : {0x1p-250, 0x1p-200, 0x1p200, 0x1p249}) {
    const Point2 a{{s, s}}, b{{2 * s, s}}, c{{2 * s, 2 * s}}, d{{s, 2 * s}};
    const Point2 in{{std::nextafter(s, 2 * s), 2 * s}};
    EXPECT_EQ(InCircleSign(a, b, c, d), 0) << s;
    EXPECT_EQ(InCircleSign(a, b, c, in), 1) << s;
    EXPECT_EQ(Orientation(a, {{1.5 * s, 1.5 * s}}, c), 0) << s;
    EXPECT_TRUE(InDiametralBall(a, b, {{1.5 * s, s}})) << s;
    EXPECT_FALSE(InDiametralBall(a, b, b)) << s;
  }
}

TEST(Predicates, TheGreatestOfFourCocircularPointsIsTheOneCutOff) {
  const Point2 a{{0, 0}}, b{{1, 0}}, c{{1, 1}}, d{{0, 1}};
  // c is lexicographically greatest and rises most, so the other three share a face.
  EXPECT_FALSE(InCircle(a, b, d, c));
  EXPECT_TRUE(InCircle(a, b, c, d));
  // Here the least is not opposite to the greatest, so the two rules would differ.
  const Point2 w{{-5, 0}}, x{{0, -5}}, y{{3, -4}}, z{{4, 3}};
  EXPECT_FALSE(InCircle(w, x, y, z));
  EXPECT_TRUE(InCircle(x, y, z, w));
  // -0 is 0: the order of coordinates, not of bits, decides.
  EXPECT_FALSE(InCircle({{-0.0, 0}}, b, {{0, 1}}, c));
}

}  // namespace
}  // namespace dynmesh::geometry::predicates_test
