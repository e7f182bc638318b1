#include "client/cleaning/clean_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "tests/client/cleaning/surface_oracle.h"

namespace dynmesh::cleaning {
namespace {

constexpr double kTolerance = 1e-9;

SurfaceCleanResult Cleaned(const std::vector<Feature>& features, bool holes = true) {
  SurfaceCleanOptions options;
  options.tolerance = kTolerance;
  options.holes = holes;
  const auto result = CleanSurfaces(features, options);
  EXPECT_TRUE(result.ok()) << result.status();
  if (!result.ok()) return {};
  EXPECT_EQ(FaultOf(PlainOf(result->features)), "");
  return *result;
}

std::map<SurfaceChangeKind, int> CountsOf(const SurfaceCleanResult& result) {
  std::map<SurfaceChangeKind, int> counts;
  for (const SurfaceChange& change : result.changes) ++counts[change.kind];
  return counts;
}

std::vector<Feature> PolygonsOf(const std::vector<Feature>& features) {
  std::vector<Feature> polygons;
  std::ranges::copy_if(features, std::back_inserter(polygons),
                       [](const Feature& f) { return f.kind == FeatureKind::kPolygon; });
  return polygons;
}

double AreaOf(const std::vector<Feature>& features) {
  double area = 0;
  for (const auto& t : PlainOf(features).triangles) {
    std::array<double, 3> u, w;
    for (std::size_t k = 0; k < 3; ++k) u[k] = t[1][k] - t[0][k], w[k] = t[2][k] - t[0][k];
    area += std::hypot(u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2],
                       u[0] * w[1] - u[1] * w[0]) /
            2;
  }
  return area;
}

TEST(CleanSurfaces, CleanInputStaysAsItIs) {
  const std::vector<Feature> cube = {Feature::Point(1, 0, 0, 0),
                                     Feature::Point(2, 1, 0, 0),
                                     Feature::Point(3, 1, 1, 0),
                                     Feature::Point(4, 0, 1, 0),
                                     Feature::Point(5, 0, 0, 1),
                                     Feature::Point(6, 1, 0, 1),
                                     Feature::Point(7, 1, 1, 1),
                                     Feature::Point(8, 0, 1, 1),
                                     Feature::Segment(9, 1, 2),
                                     Feature::Polygon(10, {{1, 4, 3, 2}}),
                                     Feature::Polygon(11, {{5, 6, 7, 8}}),
                                     Feature::Polygon(12, {{1, 2, 6, 5}}),
                                     Feature::Polygon(13, {{2, 3, 7, 6}}),
                                     Feature::Polygon(14, {{3, 4, 8, 7}}),
                                     Feature::Polygon(15, {{4, 1, 5, 8}})};
  const SurfaceCleanResult result = Cleaned(cube);
  EXPECT_EQ(result.features, cube);
  EXPECT_TRUE(result.changes.empty());
}

TEST(CleanSurfaces, CrossingTrianglesShareTheSegmentWhereTheyCross) {
  const SurfaceCleanResult result =
      Cleaned({Feature::Point(1, 0, 0, 0), Feature::Point(2, 4, 0, 0), Feature::Point(3, 0, 4, 0),
               Feature::Point(4, 1, 1, -1), Feature::Point(5, 1, 1, 1), Feature::Point(6, 1, -3, 0),
               Feature::Polygon(7, {{1, 2, 3}}), Feature::Polygon(8, {{4, 5, 6}})});
  // They cross from (1, 1, 0) to (1, 0, 0).
  const auto faces = FacesOf(result.features);
  const auto has_edge = [&](const std::set<Place3>& face) {
    return face.contains({1, 1, 0}) && face.contains({1, 0, 0});
  };
  EXPECT_EQ(std::ranges::count_if(faces, has_edge), 4);
  EXPECT_EQ(CountsOf(result)[SurfaceChangeKind::kFaceCrossed], 2);
  EXPECT_DOUBLE_EQ(AreaOf(result.features), 8 + 4);
  EXPECT_EQ(result.parts.size() + 2, PolygonsOf(result.features).size());
  for (const auto& [part, whole] : result.parts) {
    EXPECT_GT(part, 8U);
    EXPECT_TRUE(whole == 7 || whole == 8);
  }
}

TEST(CleanSurfaces, AnEdgeIsSplitAtATJunction) {
  const SurfaceCleanResult result = Cleaned(
      {Feature::Point(1, 0, 0, 0), Feature::Point(2, 2, 0, 0), Feature::Point(3, 1, 1, 0),
       Feature::Point(4, 1, 1e-10, 0), Feature::Point(5, 0, -1, 0), Feature::Point(6, 2, -1, 0),
       Feature::Polygon(7, {{1, 2, 3}}), Feature::Polygon(8, {{4, 5, 6}})});
  EXPECT_EQ(CountsOf(result)[SurfaceChangeKind::kEdgeSplit], 1);
  EXPECT_EQ(FacesOf(result.features),
            (std::set<std::set<Place3>>{{{0, 0, 0}, {1, 1e-10, 0}, {1, 1, 0}},
                                        {{2, 0, 0}, {1, 1e-10, 0}, {1, 1, 0}},
                                        {{1, 1e-10, 0}, {0, -1, 0}, {2, -1, 0}}}));
}

TEST(CleanSurfaces, CracksNarrowerThanTheToleranceAreClosed) {
  const SurfaceCleanResult result = Cleaned(
      {Feature::Point(1, 0, 0, 0), Feature::Point(2, 1, 0, 0), Feature::Point(3, 0, 1, 0),
       Feature::Point(4, 1, 1e-10, 0), Feature::Point(5, 1e-10, 1, 0), Feature::Point(6, 1, 1, 0.5),
       Feature::Polygon(7, {{1, 2, 3}}), Feature::Polygon(8, {{4, 5, 6}})});
  EXPECT_EQ(PolygonsOf(result.features), (std::vector<Feature>{Feature::Polygon(7, {{1, 2, 3}}),
                                                               Feature::Polygon(8, {{2, 3, 6}})}));
  EXPECT_EQ(CountsOf(result)[SurfaceChangeKind::kPointMerged], 2);
}

TEST(CleanSurfaces, DegenerateAndRepeatedFacesGoAndTheLeastIdStays) {
  const SurfaceCleanResult result =
      Cleaned({Feature::Point(1, 0, 0, 0), Feature::Point(2, 1, 0, 0), Feature::Point(3, 0, 1, 0),
               Feature::Point(4, 2, 0, 0), Feature::Point(5, 9, 9, 9),
               Feature::Polygon(6, {{3, 2, 1}}), Feature::Polygon(7, {{1, 2, 3}}),
               Feature::Polygon(8, {{1, 2, 1}}), Feature::Polygon(9, {{2, 2, 2}}),
               Feature::Polygon(10, {{1, 2, 4}}), Feature::Polygon(11, {{1}})});
  EXPECT_EQ(result.features,
            (std::vector<Feature>{Feature::Point(1, 0, 0, 0), Feature::Point(2, 1, 0, 0),
                                  Feature::Point(3, 0, 1, 0), Feature::Point(5, 9, 9, 9),
                                  Feature::Polygon(6, {{3, 2, 1}})}));
  auto counts = CountsOf(result);
  EXPECT_EQ(counts[SurfaceChangeKind::kFaceDoubled], 1);
  EXPECT_EQ(counts[SurfaceChangeKind::kFaceDropped], 5);  // with 7, that is one with 6
}

TEST(CleanSurfaces, FacesThatAreNotFlatBecomeTriangles) {
  for (const double height : {0.0, 1e-4}) {
    const SurfaceCleanResult result = Cleaned(
        {Feature::Point(1, 0, 0, 0), Feature::Point(2, 1, 0, 0), Feature::Point(3, 1, 1, height),
         Feature::Point(4, 0, 1, 0), Feature::Polygon(5, {{1, 2, 3, 4}})});
    EXPECT_EQ(PolygonsOf(result.features).size(), height == 0 ? 1U : 2U);
    EXPECT_EQ(result.changes.size(), height == 0 ? 0U : 1U);
  }
}

TEST(CleanSurfaces, OverlapsInAPlaneBecomeOneLayerOfExactCorners) {
  const SurfaceCleanResult result =
      Cleaned({Feature::Point(1, 0, 0, 1), Feature::Point(2, 2, 0, 1), Feature::Point(3, 2, 2, 1),
               Feature::Point(4, 0, 2, 1), Feature::Point(5, 1, 1, 1), Feature::Point(6, 3, 1, 1),
               Feature::Point(7, 3, 3, 1), Feature::Point(8, 1, 3, 1),
               Feature::Polygon(9, {{1, 2, 3, 4}}), Feature::Polygon(10, {{5, 6, 7, 8}})});
  EXPECT_DOUBLE_EQ(AreaOf(result.features), 7);
  EXPECT_EQ(PlainOf(result.features).points.size(), 10U);
  for (const Place3& p : PlainOf(result.features).points) EXPECT_EQ(p[2], 1);
  EXPECT_GT(CountsOf(result)[SurfaceChangeKind::kFaceDoubled], 0);
}

TEST(CleanSurfaces, APolygonKeepsItsHole) {
  const std::vector<Feature> frame = {Feature::Point(1, 0, 0, 0),
                                      Feature::Point(2, 3, 0, 0),
                                      Feature::Point(3, 3, 3, 0),
                                      Feature::Point(4, 0, 3, 0),
                                      Feature::Point(5, 1, 1, 0),
                                      Feature::Point(6, 2, 1, 0),
                                      Feature::Point(7, 2, 2, 0),
                                      Feature::Point(8, 1, 2, 0),
                                      Feature::Polygon(9, {{1, 2, 3, 4}, {5, 6, 7, 8}})};
  SurfaceCleanOptions options;
  options.tolerance = kTolerance;
  const auto kept = CleanSurfaces(frame, options);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->features, frame);
  const SurfaceCleanResult cut = Cleaned(frame, false);
  EXPECT_EQ(PolygonsOf(cut.features).size(), 8U);
  EXPECT_DOUBLE_EQ(AreaOf(cut.features), 8);
}

TEST(CleanSurfaces, TheInsideOfAFaceThatCrossesItselfIsEvenOdd) {
  // A square whose left half is passed round the other way: two triangles. And a ring that passes
  // round a square and then, within, round a smaller one, in which it therefore is not.
  const SurfaceCleanResult bow =
      Cleaned({Feature::Point(1, 0, 0, 0), Feature::Point(2, 4, 4, 0), Feature::Point(3, 4, 0, 0),
               Feature::Point(4, 0, 4, 0), Feature::Polygon(5, {{1, 2, 3, 4}})});
  EXPECT_DOUBLE_EQ(AreaOf(bow.features), 8);
  EXPECT_EQ(CountsOf(bow)[SurfaceChangeKind::kFaceTriangulated], 1);
  const SurfaceCleanResult spiral =
      Cleaned({Feature::Point(1, 0, 0, 0), Feature::Point(2, 8, 0, 0), Feature::Point(3, 8, 8, 0),
               Feature::Point(4, 0, 8, 0), Feature::Point(5, 2, 2, 0), Feature::Point(6, 4, 2, 0),
               Feature::Point(7, 4, 4, 0), Feature::Point(8, 2, 4, 0),
               Feature::Polygon(9, {{1, 2, 3, 4, 1, 5, 6, 7, 8, 5}})});
  EXPECT_DOUBLE_EQ(AreaOf(spiral.features), 60);
}

// Two faces that cross beside corners of both. A part of one is 5 tolerances wide at its wide end;
// the normal from its far corner is mostly rounding.
TEST(CleanSurfaces, AResultWithAVeryThinFaceStaysWhenItIsCleanedAgain) {
  constexpr double kStep = 0x1p-36;
  const auto point = [](FeatureId id, std::array<double, 3> p, std::array<double, 3> steps) {
    for (std::size_t k = 0; k < 3; ++k) p[k] += steps[k] * kStep;
    return Feature::Point(id, p[0], p[1], p[2]);
  };
  SurfaceCleanOptions options;
  options.tolerance = kStep;
  const auto cleaned =
      CleanSurfaces({point(1, {0, 0, 2}, {1, 1, 0}), point(2, {2, 1, 0}, {1.5, 0.5, 1.5}),
                     point(3, {1, 2, 0}, {1.5, 1.5, 0}), point(4, {0, 2, 2}, {0.5, 0, 0.5}),
                     point(5, {2, 1, 0}, {0, 1, 0}), point(6, {0, 0, 0}, {0, 0, 0}),
                     Feature::Polygon(7, {{1, 2, 3}}), Feature::Polygon(8, {{4, 5, 6}})},
                    options);
  ASSERT_TRUE(cleaned.ok()) << cleaned.status();
  EXPECT_EQ(cleaned->tolerance, kStep);
  EXPECT_EQ(FaultOf(PlainOf(cleaned->features)), "");
  const auto again = CleanSurfaces(cleaned->features, options);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->features, cleaned->features);
  EXPECT_EQ(again->tolerance, kStep);
}

TEST(CleanSurfaces, SegmentsAndPointsTakePart) {
  const SurfaceCleanResult result =
      Cleaned({Feature::Point(1, 0, 0, 0), Feature::Point(2, 4, 0, 0), Feature::Point(3, 0, 4, 0),
               Feature::Point(4, 1, 1, -1), Feature::Point(5, 1, 1, 1),
               Feature::Point(6, 2, 1, 1e-11), Feature::Segment(7, 4, 5), Feature::Segment(8, 5, 4),
               Feature::Segment(9, 4, 4), Feature::Polygon(10, {{1, 2, 3}})});
  auto counts = CountsOf(result);
  EXPECT_EQ(counts[SurfaceChangeKind::kFaceSplit], 1);    // at the point 6
  EXPECT_EQ(counts[SurfaceChangeKind::kFaceCrossed], 1);  // by the segment
  EXPECT_EQ(counts[SurfaceChangeKind::kSegmentDoubled], 1);
  EXPECT_EQ(counts[SurfaceChangeKind::kSegmentDropped], 2);  // with 8, that is one with 7
  std::vector<Feature> segments;
  for (const Feature& f : result.features) {
    if (f.kind == FeatureKind::kSegment) segments.push_back(f);
  }
  EXPECT_EQ(segments,
            (std::vector<Feature>{Feature::Segment(7, 4, 11), Feature::Segment(12, 11, 5)}));
}

// Needles side by side at one corner: more pairs than steps.
TEST(CleanSurfaces, ACrowdIsAnErrorBeforeItIsCompared) {
  constexpr std::size_t kNeedles = 3000;
  std::vector<Feature> features = {Feature::Point(1, 0, 0, 0)};
  for (std::size_t i = 0; i <= kNeedles; ++i) {
    features.push_back(Feature::Point(2 + i, 1 + 1e-3 * static_cast<double>(i), 1e-6, 0));
  }
  for (std::size_t i = 0; i < kNeedles; ++i) {
    features.push_back(Feature::Polygon(10'000 + i, {{1, 2 + i, 3 + i}}));
  }
  SurfaceCleanOptions options;
  options.tolerance = kTolerance;
  options.max_steps = kNeedles * kNeedles / 4;
  const absl::Status status = CleanSurfaces(features, options).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_NE(status.message().find("too many steps: in round 1 3000"), std::string::npos) << status;
  EXPECT_NE(status.message().find("one at (0, 0, 0)"), std::string::npos) << status;
}

// The end of each of two faces' edges is on an edge of the other face: cut at one, the needle has
// the other one on its new edge, for ever.
TEST(CleanSurfaces, WhereCutsOfANeedleUndoEachOtherItsShortEdgeIsContracted) {
  const std::vector<Feature> needle = {
      Feature::Point(1, 0, 0, 0),       Feature::Point(2, 0, 3.8, 0),
      Feature::Point(3, 2e-5, 3.2, 0),  Feature::Point(4, 2e-5 - 1.1e-10, 3.2 + 8e-6, 0),
      Feature::Point(5, 1, 3.2, 1),     Feature::Polygon(6, {{1, 2, 3}}),
      Feature::Polygon(7, {{3, 4, 5}}),
  };
  SurfaceCleanOptions options;
  options.tolerance = kTolerance;
  EXPECT_TRUE(absl::IsResourceExhausted(CleanSurfaces(needle, options).status()));
  options.most_contraction = 7e-6;  // too little
  EXPECT_TRUE(absl::IsResourceExhausted(CleanSurfaces(needle, options).status()));
  options.most_contraction = 1e-5;
  const auto result = CleanSurfaces(needle, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->tolerance, kTolerance);
  EXPECT_EQ(FaultOf(PlainOf(result->features)), "");
  EXPECT_EQ(CountsOf(*result).at(SurfaceChangeKind::kPointMerged), 1);
  EXPECT_EQ(PolygonsOf(result->features).size(), 1U);
  // What is contracted does not depend on ids.
  std::vector<Feature> turned = needle;
  turned[5].rings = {{3, 2, 1}};
  std::swap(turned[5].id, turned[6].id);
  const auto again = CleanSurfaces(turned, options);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(PlainOf(again->features).points, PlainOf(result->features).points);
}

TEST(CleanSurfaces, SizesStay) {
  const std::vector<Feature> features = {
      Feature::Point(1, 0, 0, 0), Feature::Size(2, {1, 1, 1}, {SizeShape::kDisc, 0.1, 0.5, {}})};
  EXPECT_EQ(Cleaned(features).features, features);
}

TEST(CleanSurfaces, InvalidInputIsRefusedByName) {
  const auto refusal = [](const std::vector<Feature>& features, double tolerance = kTolerance) {
    SurfaceCleanOptions options;
    options.tolerance = tolerance;
    const absl::Status status = CleanSurfaces(features, options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    const auto detail = GetErrorDetail(status);
    return detail ? detail->reason : std::string(status.message());
  };
  const Feature p = Feature::Point(1, 0, 0, 0);
  EXPECT_EQ(refusal({p, p}), reason::kIdInUse);
  EXPECT_EQ(refusal({Feature::Point(0, 0, 0, 0)}), reason::kBadId);
  EXPECT_EQ(refusal({p, Feature::Polygon(2, {{1, 3, 4}})}), reason::kUnknownEnd);
  EXPECT_EQ(refusal({p, Feature::Segment(2, 1, 2)}), reason::kUnknownEnd);
  for (const double x : {std::numeric_limits<double>::infinity(), std::nan(""), 0x1p141}) {
    EXPECT_EQ(refusal({Feature::Point(1, 0, 0, x)}), reason::kNotFinite);
  }
  for (const double tolerance : {0.0, -1.0, 1e-14, std::nan("")}) {
    EXPECT_NE(refusal({Feature::Point(1, 0, 0, 1)}, tolerance).find("tolerance"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace dynmesh::cleaning
