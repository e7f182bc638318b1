// Polygons in CleanInput, case by case.
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "client/cleaning/clean_input.h"
#include "dynmesh/error.h"
#include "gtest/gtest.h"

namespace dynmesh::cleaning::clean_polygons_test {
namespace {

using Ids = std::vector<FeatureId>;

CleanResult Clean(const std::vector<Feature>& features) {
  CleanOptions options;
  options.tolerance = 0.01;
  const auto result = CleanInput(features, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *result : CleanResult();
}

Feature P(FeatureId id, double x, double y) { return Feature::Point(id, x, y); }
Feature S(FeatureId id, FeatureId p, FeatureId q) { return Feature::Segment(id, p, q); }
Feature G(FeatureId id, Rings rings) { return Feature::Polygon(id, std::move(rings)); }

// 1 2 3 4: the unit square.
std::vector<Feature> SquareAnd(const std::vector<Feature>& more) {
  std::vector<Feature> all = {P(1, 0, 0), P(2, 1, 0), P(3, 1, 1), P(4, 0, 1)};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::vector<ChangeKind> KindsOf(const CleanResult& result) {
  std::vector<ChangeKind> kinds;
  for (const Change& change : result.changes) kinds.push_back(change.kind);
  return kinds;
}

// A ring's start, direction and position in the list do not matter.
Rings Canonical(Rings rings) {
  for (auto& ring : rings) {
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    if (ring.size() > 1 && ring.back() < ring[1]) std::reverse(ring.begin() + 1, ring.end());
  }
  std::sort(rings.begin(), rings.end());
  return rings;
}

// All but the points, rings canonical.
std::vector<Feature> RestOf(const CleanResult& result) {
  std::vector<Feature> rest;
  for (const Feature& f : result.features) {
    if (f.kind == FeatureKind::kPoint) continue;
    rest.push_back(f);
    rest.back().rings = Canonical(f.rings);
  }
  return rest;
}

TEST(CleanPolygons, CleanPolygonsAreLeftAlone) {
  const std::vector<Feature> features = {G(9, {{3, 4, 1, 2}, {6, 5, 7}}),
                                         P(1, 0, 0),
                                         P(2, 1, 0),
                                         P(3, 1, 1),
                                         P(4, 0, 1),
                                         P(5, 0.2, 0.2),
                                         P(6, 0.4, 0.2),
                                         P(7, 0.4, 0.4),
                                         S(8, 1, 2),
                                         Feature::SizePolygon(10, {{1, 3, 4}}, 0.1)};
  const CleanResult result = Clean(features);
  EXPECT_TRUE(result.changes.empty());
  EXPECT_EQ(result.features, features);
}

TEST(CleanPolygons, CornersGoWhereTheyAreMerged) {
  const Feature size = Feature::SizePolygon(8, {{5, 6, 3}}, 0.1);
  const CleanResult result = Clean(
      SquareAnd({P(5, 1.004, 0.001), P(6, 2, 0.5), G(7, {{1, 2, 3, 4}}), size, G(9, {{6, 3, 5}})}));
  EXPECT_EQ(RestOf(result),
            (std::vector<Feature>{G(7, {{1, 2, 3, 4}}), Feature::SizePolygon(8, {{2, 3, 6}}, 0.1),
                                  G(9, {{2, 3, 6}})}));
  EXPECT_EQ(KindsOf(result), std::vector<ChangeKind>{ChangeKind::kPointMerged});
}

TEST(CleanPolygons, AnEdgeWithAPointOnItBecomesTheChainThroughIt) {
  const CleanResult result = Clean(SquareAnd({P(5, 0.5, 0.001), G(6, {{1, 2, 3, 4}})}));
  EXPECT_EQ(RestOf(result), (std::vector<Feature>{G(6, {{1, 4, 3, 2, 5}})}));
  ASSERT_EQ(KindsOf(result), std::vector<ChangeKind>{ChangeKind::kSegmentSplit});
  EXPECT_EQ(result.changes[0].ids, (Ids{6, 5}));
}

TEST(CleanPolygons, OverlappingPolygonsGetPointsWhereTheyCross) {
  const CleanResult result =
      Clean(SquareAnd({P(5, 0.5, 0.25), P(6, 2, 0.25), P(7, 2, 0.75), P(8, 0.5, 0.75),
                       G(9, {{1, 2, 3, 4}}), G(10, {{5, 6, 7, 8}})}));
  EXPECT_EQ(RestOf(result),
            (std::vector<Feature>{G(9, {{1, 2, 11, 12, 3, 4}}), G(10, {{5, 8, 12, 7, 6, 11}})}));
  ASSERT_EQ(KindsOf(result),
            (std::vector<ChangeKind>{ChangeKind::kSegmentsCrossed, ChangeKind::kSegmentsCrossed}));
  EXPECT_EQ(result.changes[0].ids, (Ids{10, 9, 11}));
}

TEST(CleanPolygons, SegmentsOnEdgesStayAndEdgesBecomeNone) {
  const CleanResult result =
      Clean(SquareAnd({P(5, 0.5, 0), S(6, 1, 5), S(7, 4, 2), G(8, {{1, 2, 3, 4}})}));
  EXPECT_EQ(RestOf(result),
            (std::vector<Feature>{S(6, 1, 5), S(7, 4, 2), G(8, {{1, 4, 3, 2, 5}})}));
  EXPECT_EQ(KindsOf(result), std::vector<ChangeKind>{ChangeKind::kSegmentSplit});
}

TEST(CleanPolygons, AFigureOfEightIsTwoRings) {
  const CleanResult result = Clean(SquareAnd({G(5, {{1, 3, 2, 4}})}));
  EXPECT_EQ(RestOf(result), (std::vector<Feature>{G(5, {{1, 4, 6}, {2, 3, 6}})}));
  ASSERT_EQ(KindsOf(result),
            (std::vector<ChangeKind>{ChangeKind::kSegmentsCrossed, ChangeKind::kRingCut}));
  EXPECT_EQ(result.changes[1].ids, (Ids{5, 6}));
  EXPECT_EQ(result.changes[1].to, (std::array<double, 2>{0.5, 0.5}));
}

TEST(CleanPolygons, ARingThatComesToAPointTwiceIsCutThere) {
  const std::vector<Feature> input =
      SquareAnd({P(5, 0.5, 0.5), G(6, {{1, 2, 5, 3, 4, 5}}),
                 Feature::SizePolygon(7, {{1, 2, 5, 3, 4, 5}}, 0.1)});
  const CleanResult result = Clean(input);
  const std::vector<Feature> rest = RestOf(result);
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_EQ(rest[0].rings, (Rings{{1, 2, 5}, {3, 4, 5}}));
  EXPECT_EQ(rest[1].rings, rest[0].rings);
  EXPECT_EQ(KindsOf(result), (std::vector<ChangeKind>{ChangeKind::kRingCut, ChangeKind::kRingCut}));
}

TEST(CleanPolygons, WhatIsUsedTwiceCancels) {
  // A spike to 5, and two rings with a common side.
  const CleanResult spike = Clean(SquareAnd({P(5, 2, 0), G(6, {{1, 2, 5, 2, 3, 4}})}));
  EXPECT_EQ(RestOf(spike), (std::vector<Feature>{G(6, {{1, 2, 3, 4}})}));
  ASSERT_EQ(KindsOf(spike), std::vector<ChangeKind>{ChangeKind::kCancelled});
  EXPECT_EQ(spike.changes[0].ids, Ids{6});
  const CleanResult halves = Clean(SquareAnd({G(6, {{1, 2, 3}, {3, 4, 1}})}));
  EXPECT_EQ(RestOf(halves), (std::vector<Feature>{G(6, {{1, 2, 3, 4}})}));
}

TEST(CleanPolygons, APolygonWithoutARingLeftIsDropped) {
  const CleanResult result =
      Clean(SquareAnd({P(5, 0.001, 0), P(6, 0, 0.001), G(7, {{1, 5, 6}}),
                       G(8, {{1, 2, 3}, {2, 3, 1}}), G(9, {{1, 2}}), G(10, {}),
                       Feature::SizePolygon(11, {{5, 1, 2}}, 0.1), G(12, {{1, 3, 4}, {5, 6, 1}})}));
  EXPECT_EQ(RestOf(result), (std::vector<Feature>{G(12, {{1, 3, 4}})}));
  std::vector<FeatureId> dropped;
  for (const Change& change : result.changes) {
    if (change.kind == ChangeKind::kPolygonDropped) dropped.push_back(change.ids.front());
  }
  EXPECT_EQ(dropped, (Ids{7, 8, 9, 10, 11}));
}

TEST(CleanPolygons, EdgesOfSizingPolygonsMeetNobody) {
  const std::vector<Feature> input =
      SquareAnd({P(5, 2, 2), Feature::SizePolygon(6, {{1, 3, 2, 4}}, 0.1), S(7, 1, 5)});
  const CleanResult result = Clean(input);
  EXPECT_EQ(KindsOf(result), std::vector<ChangeKind>{ChangeKind::kSegmentSplit});  // 7, at 3
  EXPECT_EQ(RestOf(result), (std::vector<Feature>{S(7, 1, 3), S(8, 3, 5), input[5]}));
}

TEST(CleanPolygons, CornersThatAreNoPointsAreNamed) {
  CleanOptions options;
  options.tolerance = 0.01;
  for (const Feature& bad : {G(5, {{1, 2, 7}}), Feature::SizePolygon(5, {{1, 2, 6}}, 0.1)}) {
    const auto result = CleanInput(SquareAnd({bad, S(6, 1, 2)}), options);
    const auto detail = GetErrorDetail(result.status());
    ASSERT_TRUE(detail.has_value()) << result.status();
    EXPECT_EQ(detail->reason, reason::kUnknownEnd);
    EXPECT_EQ(detail->features, (Ids{5, bad.rings[0][2]}));
  }
}

}  // namespace
}  // namespace dynmesh::cleaning::clean_polygons_test
