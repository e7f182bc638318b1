#include "client/cleaning/clean_input.h"

#include <limits>

#include "dynmesh/error.h"
#include "gtest/gtest.h"

namespace dynmesh::cleaning::clean_input_test {
namespace {

constexpr double kTolerance = 0.01;

CleanResult Clean(const std::vector<Feature>& features) {
  CleanOptions options;
  options.tolerance = kTolerance;
  const auto result = CleanInput(features, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *result : CleanResult();
}

Feature P(FeatureId id, double x, double y) { return Feature::Point(id, x, y); }
Feature S(FeatureId id, FeatureId p, FeatureId q) { return Feature::Segment(id, p, q); }

std::vector<ChangeKind> KindsOf(const CleanResult& result) {
  std::vector<ChangeKind> kinds;
  for (const Change& change : result.changes) kinds.push_back(change.kind);
  return kinds;
}

TEST(CleanInput, CleanInputIsLeftAlone) {
  const std::vector<Feature> features = {P(3, 0, -0.0), P(1, 1, 0), S(9, 3, 1), P(2, 0.5, 0.5)};
  const CleanResult result = Clean(features);
  EXPECT_TRUE(result.changes.empty());
  EXPECT_EQ(result.features, features);
  EXPECT_TRUE(Clean({}).features.empty());
}

TEST(CleanInput, PointsThatAreNearlyOneAreMerged) {
  const CleanResult result =
      Clean({P(1, 0, 0), P(2, 1, 0), P(3, 1, 0), P(4, 1.004, 0.003), S(5, 1, 4)});
  EXPECT_EQ(result.features, (std::vector<Feature>{P(1, 0, 0), P(2, 1, 0), S(5, 1, 2)}));
  ASSERT_EQ(KindsOf(result),
            (std::vector<ChangeKind>{ChangeKind::kPointMerged, ChangeKind::kPointMerged}));
  EXPECT_EQ(result.changes[1].ids, (std::vector<FeatureId>{4, 2}));
  EXPECT_EQ(result.changes[1].from, (std::array<double, 2>{1.004, 0.003}));
  EXPECT_EQ(result.changes[1].to, (std::array<double, 2>{1, 0}));
}

TEST(CleanInput, SegmentsAreSplitWhereTheyCross) {
  const CleanResult result =
      Clean({P(1, 0, 0), P(2, 1, 1), P(3, 0, 1), P(4, 1, 0), S(5, 1, 2), S(6, 4, 3)});
  EXPECT_EQ(result.features,
            (std::vector<Feature>{P(1, 0, 0), P(2, 1, 1), P(3, 0, 1), P(4, 1, 0), P(7, 0.5, 0.5),
                                  S(5, 1, 7), S(8, 7, 2), S(6, 4, 7), S(9, 7, 3)}));
  ASSERT_EQ(result.changes.size(), 1U);
  EXPECT_EQ(result.changes[0].kind, ChangeKind::kSegmentsCrossed);
  EXPECT_EQ(result.changes[0].from, (std::array<double, 2>{0.5, 0.5}));
  EXPECT_EQ(result.changes[0].ids.back(), 7U);
}

TEST(CleanInput, ManySegmentsThroughOnePlaceGetOnePoint) {
  const CleanResult result =
      Clean({P(1, 0, 0.5), P(2, 1, 0.5), P(3, 0.5, 0), P(4, 0.5, 1), P(5, 0, 0.001), P(6, 1, 1),
             S(7, 1, 2), S(8, 3, 4), S(9, 5, 6)});
  std::size_t points = 0, segments = 0;
  for (const Feature& f : result.features) {
    ++(f.kind == FeatureKind::kPoint ? points : segments);
  }
  EXPECT_EQ(points, 7U);
  EXPECT_EQ(segments, 6U);
}

TEST(CleanInput, ACrossingNearAPointGoesThroughTheNearest) {
  CleanOptions options;
  options.tolerance = 1;
  const auto result = CleanInput({P(1, -0.6, 0), P(2, 0.6, 0), P(3, -1.59, 2.544),
                                  P(4, 1.59, -2.544), P(5, 0.298, 0.954), S(6, 1, 2), S(7, 3, 4)},
                                 options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->features, (std::vector<Feature>{P(1, -0.6, 0), P(2, 0.6, 0), P(3, -1.59, 2.544),
                                                    P(4, 1.59, -2.544), P(5, 0.298, 0.954),
                                                    S(6, 1, 2), S(7, 3, 1), S(8, 1, 4)}));
  EXPECT_EQ(KindsOf(*result), (std::vector<ChangeKind>{ChangeKind::kSegmentsCrossed}));
}

TEST(CleanInput, APointBesideASegmentIsPutOnIt) {
  const CleanResult result = Clean(
      {P(1, 0, 0), P(2, 1, 0), P(3, 0.25, 0.004), P(4, 0.75, 0), P(5, 0.5, 0.008), S(6, 2, 1)});
  EXPECT_EQ(result.features,
            (std::vector<Feature>{P(1, 0, 0), P(2, 1, 0), P(3, 0.25, 0.004), P(4, 0.75, 0),
                                  P(5, 0.5, 0.008), S(6, 2, 4), S(7, 4, 3), S(8, 3, 1)}));
  ASSERT_EQ(KindsOf(result),
            (std::vector<ChangeKind>{ChangeKind::kSegmentSplit, ChangeKind::kSegmentSplit}));
  EXPECT_EQ(result.changes[0].ids, (std::vector<FeatureId>{6, 3}));
  EXPECT_EQ(result.changes[0].from, (std::array<double, 2>{0.25, 0}));
}

TEST(CleanInput, WhatSegmentsShareIsKeptOnce) {
  const CleanResult result =
      Clean({P(1, 0, 0), P(2, 1, 0), P(3, 2, 0), P(4, 3, 0), S(5, 1, 3), S(6, 4, 2), S(7, 3, 1)});
  EXPECT_EQ(result.features, (std::vector<Feature>{P(1, 0, 0), P(2, 1, 0), P(3, 2, 0), P(4, 3, 0),
                                                   S(5, 1, 2), S(8, 2, 3), S(6, 4, 3)}));
}

TEST(CleanInput, SegmentsOfNoLengthAreDropped) {
  const CleanResult result =
      Clean({P(1, 0, 0), P(2, 0.001, 0), P(3, 1, 0), S(4, 1, 2), S(5, 3, 3)});
  EXPECT_EQ(result.features, (std::vector<Feature>{P(1, 0, 0), P(3, 1, 0)}));
  ASSERT_EQ(KindsOf(result),
            (std::vector<ChangeKind>{ChangeKind::kPointMerged, ChangeKind::kZeroLength,
                                     ChangeKind::kZeroLength}));
}

TEST(CleanInput, SegmentsAtATinyAngleAreLaidOnEachOther) {
  // 0.0005 degrees; the shorter one's end is 0.87 off the longer one.
  const CleanResult result =
      Clean({P(1, 0, 0), P(2, 200000, 0), P(3, 100000, 0.87), S(4, 1, 2), S(5, 1, 3)});
  EXPECT_EQ(result.features, (std::vector<Feature>{P(1, 0, 0), P(2, 200000, 0), P(3, 100000, 0.87),
                                                   S(4, 1, 3), S(6, 3, 2)}));
  ASSERT_EQ(KindsOf(result),
            (std::vector<ChangeKind>{ChangeKind::kSmallAngle, ChangeKind::kDoubled}));
  EXPECT_EQ(result.changes[0].ids, (std::vector<FeatureId>{4, 5, 3}));
}

TEST(CleanInput, SizingFeaturesStayAsTheyAre) {
  const Feature size = Feature::SizeDisc(3, 0.5, 0.5, 0.1, 0.01);
  const CleanResult result = Clean({P(1, 0, 0), size, P(2, 0, 0), S(4, 1, 2)});
  EXPECT_EQ(result.features, (std::vector<Feature>{P(1, 0, 0), size}));
}

TEST(CleanInput, CoordinatesTooNearToZeroBecomeZero) {
  const CleanResult result = Clean({P(1, 1e-300, 1), P(2, 0.5, 0.5)});
  EXPECT_EQ(result.features, (std::vector<Feature>{P(1, 0, 1), P(2, 0.5, 0.5)}));
  EXPECT_EQ(KindsOf(result), (std::vector<ChangeKind>{ChangeKind::kPointRounded}));
}

TEST(CleanInput, BadFeaturesAreNamed) {
  CleanOptions options;
  options.tolerance = kTolerance;
  const struct {
    std::vector<Feature> features;
    const char* reason;
    FeatureId first;
  } kBad[] = {
      {{P(1, 0, 0), P(1, 1, 1)}, reason::kIdInUse, 1},
      {{P(0, 0, 0)}, reason::kBadId, 0},
      {{P(kBoxFeature, 0, 0)}, reason::kBadId, kBoxFeature},
      {{P(1, 0, 0), S(2, 1, 7)}, reason::kUnknownEnd, 2},
      {{P(1, 0, 0), S(2, 1, 2)}, reason::kUnknownEnd, 2},
      {{P(1, 0, std::numeric_limits<double>::quiet_NaN())}, reason::kNotFinite, 1},
      {{P(1, 0, 1e300)}, reason::kNotFinite, 1},
  };
  for (const auto& bad : kBad) {
    const auto result = CleanInput(bad.features, options);
    const auto detail = GetErrorDetail(result.status());
    ASSERT_TRUE(detail.has_value()) << result.status();
    EXPECT_EQ(detail->reason, bad.reason);
    EXPECT_EQ(detail->features.front(), bad.first);
  }
}

TEST(CleanInput, TolerancesThatCannotBeAreRefused) {
  for (const double tolerance :
       {0.0, -1.0, 1e-14, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    CleanOptions options;
    options.tolerance = tolerance;
    EXPECT_EQ(CleanInput({P(1, 1, 1)}, options).status().code(), absl::StatusCode::kInvalidArgument)
        << tolerance;
  }
}

TEST(CleanInput, PastALimitItSaysWhatIsLeft) {
  const std::vector<Feature> cross = {P(1, 0, 0), P(2, 1, 1), P(3, 0, 1),
                                      P(4, 1, 0), S(5, 1, 2), S(6, 4, 3)};
  CleanOptions options;
  options.tolerance = kTolerance;
  options.max_rounds = 1;
  const absl::Status rounds = CleanInput(cross, options).status();
  EXPECT_EQ(rounds.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_NE(rounds.message().find("(0.5, 0.5)"), absl::string_view::npos) << rounds;
  options = {};
  options.tolerance = kTolerance;
  options.max_crossings = 0;
  EXPECT_EQ(CleanInput(cross, options).status().code(), absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace dynmesh::cleaning::clean_input_test
