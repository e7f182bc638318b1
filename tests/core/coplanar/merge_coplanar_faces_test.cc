// Faces that fold, overlap, lean or are flat only within a tolerance, and straight corners.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "core/coplanar/merge_coplanar.h"
#include "dynmesh/error.h"
#include "tests/core/coplanar/face_soup.h"
#include "tests/core/coplanar/merge_coplanar_util.h"

namespace dynmesh::coplanar {
namespace {

using testing::FaceSoup;
using testing::Place;
using testing::Shape;
using testing::ShapeOf;
using testing::ShapesOf;

TEST(MergeCoplanar, AFaceFoldedOntoAnotherIsNotJoinedWithIt) {
  const std::vector<Feature> points =
      Points({{0, 0, 0}, {4, 0, 0}, {1, 4, 0}, {3, 4, 0}, {5, 5, 0}});
  std::vector<Feature> f = With(points, {{{1, 2, 3}}, {{1, 2, 4}}});
  EXPECT_EQ(Merged(f), f);
  f = With(points, {{{1, 2, 3}}, {{1, 2, 4}}, {{2, 3, 5}}});
  EXPECT_EQ(Merged(f), With(points, {{{1, 3, 5, 2}}, {{1, 2, 4}}}));
}

// An arch with both feet on one edge, which they overlap.
TEST(MergeCoplanar, ARegionThatOverlapsItselfIsLeftToValidation) {
  const std::vector<Feature> points = Points({{1, 0, 0},
                                              {3, 0, 0},
                                              {0, 3, 0},
                                              {4, 3, 0},
                                              {0, 6, 0},
                                              {4, 6, 0},
                                              {-3, 9, 0},
                                              {2, 12, 0},
                                              {7, 9, 0}});
  std::vector<Rings> faces = {{{1, 2, 3}}, {{2, 3, 5}}, {{3, 5, 7}}, {{5, 7, 8}},
                              {{5, 6, 8}}, {{6, 8, 9}}, {{4, 6, 9}}, {{1, 4, 6}}};
  EXPECT_EQ(ShapesOf(Merged(With(points, faces))).size(), 1U);
  faces.push_back({{1, 2, 4}});
  const std::vector<Feature> f = With(points, faces);
  EXPECT_EQ(Merged(f), f);
}

TEST(MergeCoplanar, ACornerWhereAnotherFaceTurnsStays) {
  std::vector<Feature> f =
      With(Points({{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {2, 0, 3}, {0, 0, 3}}),
           {{{1, 2, 3, 4, 5}}, {{1, 2, 6, 7}}});
  EXPECT_EQ(Merged(f), f);
  std::swap(f[7], f[8]);
  EXPECT_EQ(Merged(f), f);
  f.erase(f.begin() + 7);
  EXPECT_EQ(Merged(f).back(), Feature::Polygon(8, {{1, 3, 4, 5}}));  // not joined, yet straight
}

// One face has two corners on an edge, the other has one of them: they are straight in both only
// after the first is removed.
TEST(MergeCoplanar, ACornerCanGoBecauseItsNeighbourWent) {
  for (const double way : {1, -1}) {
    const std::vector<Feature> f = With(Points({{0, 0, 0},
                                                {way, 0, 0},
                                                {2 * way, 0, 0},
                                                {3 * way, 0, 0},
                                                {3 * way, 1, 0},
                                                {0, 1, 0},
                                                {3 * way, 0, 1},
                                                {0, 0, 1}}),
                                        {{{1, 2, 3, 4, 5, 6}}, {{1, 3, 4, 7, 8}}});
    std::vector<Feature> expected = Without(f, {2, 3});
    expected[6] = Feature::Polygon(9, {{1, 4, 5, 6}});
    expected[7] = Feature::Polygon(10, {{1, 4, 7, 8}});
    EXPECT_EQ(Merged(f), expected);
  }
}

TEST(MergeCoplanar, FacesWithHolesAreJoinedAndFilled) {
  std::vector<Feature> f = Points(
      {{0, 0, 1}, {9, 0, 1}, {9, 9, 1}, {0, 9, 1}, {3, 3, 1}, {6, 3, 1}, {6, 6, 1}, {3, 6, 1}});
  f.push_back(Feature::Polygon(9, {{1, 2, 3, 4}, {5, 6, 7, 8}}));
  EXPECT_EQ(Merged(f), f);
  f.push_back(Feature::Polygon(10, {{5, 6, 7}}));
  EXPECT_EQ(ShapesOf(Merged(f)),
            (std::multiset<Shape>{ShapeOf({{{0, 0, 1}, {9, 0, 1}, {9, 9, 1}, {0, 9, 1}},
                                           {{3, 3, 1}, {6, 6, 1}, {3, 6, 1}}})}));
  f.push_back(Feature::Polygon(11, {{5, 7, 8}}));
  EXPECT_EQ(ShapesOf(Merged(f)),
            (std::multiset<Shape>{ShapeOf({{{0, 0, 1}, {9, 0, 1}, {9, 9, 1}, {0, 9, 1}}})}));
}

TEST(MergeCoplanar, ATinyStepIsTakenWithATolerance) {
  std::vector<Feature> f = Points({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 1e-9}});
  f.push_back(Feature::Polygon(5, {{1, 2, 3}}));
  f.push_back(Feature::Polygon(6, {{1, 3, 4}}));
  EXPECT_EQ(Merged(f), f);
  EXPECT_EQ(Merged(f, 0.9e-9), f);
  EXPECT_EQ(Merged(f, 1.1e-9).back(), Feature::Polygon(5, {{1, 4, 3, 2}}));
}

// Over an edge 60 degrees are enough, over the inside of a polygon they are not.
TEST(MergeCoplanar, FacesAreNotJoinedBelowASegmentThatLeansOverTheirEdge) {
  const double angle = 65 * 3.141592653589793 / 180;
  for (const double lean : {1.0, 0.0, -1.0}) {
    SCOPED_TRACE(lean);
    const double along = lean * std::sqrt(0.5) * std::cos(angle);
    std::vector<Feature> f =
        With(Points({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {along, along, std::sin(angle)}}),
             {{{1, 2, 3}}, {{1, 3, 4}}});
    f.push_back(Feature::Segment(10, 1, 5));
    EXPECT_EQ(ShapesOf(Merged(f)).size(), lean > 0 ? 2U : 1U);
  }
}

// A flat floor beside a sheet that is flat only within the tolerance.
TEST(MergeCoplanar, WhatIsThickerThanAllowedIsJoinedWhereItIsFlat) {
  const std::vector<Feature> points = Points({{0, 0, 0},
                                              {4, 0, 0},
                                              {4, 2, 0},
                                              {0, 2, 0},
                                              {4, 4, 1e-6},
                                              {0, 4, -1e-6},
                                              {9, 0, 0},
                                              {9, 2, 1e-9},
                                              {9, 9, 9}});
  const std::vector<Rings> faces = {{{1, 2, 3}}, {{1, 3, 4}}, {{4, 3, 5}}, {{4, 5, 6}}};
  const std::function<double(double)> most = [](double extent) { return 1e-8 * extent; };
  const std::vector<Feature> f = With(points, faces);
  EXPECT_EQ(ShapesOf(Merged(f, 1e-5)).size(), 1U);
  const auto flat = MergeCoplanar(f, 1e-5, most);
  ASSERT_TRUE(flat.ok());
  EXPECT_EQ(flat->too_thick, 1U);
  const std::multiset<Shape> shapes = ShapesOf(flat->features);
  EXPECT_EQ(shapes.size(), 3U);
  EXPECT_TRUE(shapes.contains(ShapeOf({{{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}}})));
  // Thin parts are merged, also beside parts that are not.
  const auto thin = MergeCoplanar(With(points, {{{2, 7, 8}}, {{2, 8, 3}}}), 1e-5, most);
  ASSERT_TRUE(thin.ok());
  EXPECT_EQ(thin->too_thick, 0U);
  EXPECT_EQ(ShapesOf(thin->features).size(), 1U);
  // Without a tolerance the planarity is not tested.
  const auto exact = MergeCoplanar(f, 0, [](double) { return -1.0; });
  ASSERT_TRUE(exact.ok());
  EXPECT_EQ(exact->too_thick, 0U);
  EXPECT_EQ(ShapesOf(exact->features).size(), 3U);
}

// However fine its faces, a round body stays round, and the order has no effect.
TEST(MergeCoplanar, WithAToleranceNoRegionIsThickerThanThatToEitherSide) {
  std::mt19937 rng = NewRandom();
  for (int round = 0; round < 20; ++round) {
    FaceSoup soup;
    constexpr int kSides = 60;
    std::uniform_real_distribution<double> noise(-0.004, 0.004);
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * 3.141592653589793 * i / kSides;
      for (int z = 0; z < 4; ++z) {
        const double r = 1 + noise(rng);
        soup.points.push_back({r * std::cos(angle), r * std::sin(angle), z + noise(rng)});
      }
    }
    for (std::size_t i = 0; i < kSides; ++i) {
      for (std::size_t z = 0; z < 3; ++z) {
        const std::size_t a = 4 * i + z, b = 4 * ((i + 1) % kSides) + z;
        soup.AddQuad(a, b, b + 1, a + 1);
      }
    }
    const double tolerance = 0.01;
    const std::multiset<Shape> shapes = ShapesOf(Merged(soup.Features(), tolerance));
    EXPECT_LT(shapes.size(), soup.faces.size() / 2);
    EXPECT_GT(shapes.size(), 8U);
    for (const Shape& shape : shapes) {
      // Within t of a plane that touches the band 1 +- 0.004: at most this far around.
      for (const Place& p : shape[0]) {
        for (const Place& q : shape[0]) {
          EXPECT_LT(std::hypot(p[0] - q[0], p[1] - q[1]), 0.7);
        }
      }
    }
    soup.Shuffle(rng);
    EXPECT_EQ(ShapesOf(Merged(soup.Features(), tolerance)), shapes);
  }
}

// A folding screen of equal panels: the starting panel determines the result.
TEST(MergeCoplanar, AmongEqualFacesCoordinatesDecideWhoBegins) {
  std::mt19937 rng = NewRandom();
  FaceSoup soup;
  for (std::size_t i = 0; i < 9; ++i) {
    const double x = static_cast<double>(i), z = i % 2 == 0 ? 0 : 0.125;
    soup.points.push_back({x, 0, z});
    soup.points.push_back({x, 2, z});
    if (i > 0) soup.faces.push_back({2 * i - 2, 2 * i, 2 * i + 1, 2 * i - 1});
  }
  const std::multiset<Shape> shapes = ShapesOf(Merged(soup.Features(), 0.26));
  EXPECT_LT(shapes.size(), 8U);
  EXPECT_GT(shapes.size(), 1U);
  for (int round = 0; round < 20; ++round) {
    soup.Shuffle(rng);
    EXPECT_EQ(ShapesOf(Merged(soup.Features(), 0.26)), shapes);
  }
}

TEST(MergeCoplanar, WhatCannotBeComputedWithIsRefused) {
  const auto refused = [](const std::vector<Feature>& f, double tolerance = 0) {
    const absl::Status status = MergeCoplanar(f, tolerance).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  std::vector<Feature> f = Points({{0, 0, 0}, {1, 0, 0}, {0, 1, 1e-300}});
  EXPECT_EQ(Merged(f), f);  // no face names it
  f.push_back(Feature::Polygon(4, {{1, 2, 3}}));
  EXPECT_EQ(refused(f),
            "polygon 4 has the corner 3, which has a coordinate above 2^200 or nearer to 0 than "
            "2^-200; scale the input");
  EXPECT_EQ(GetErrorDetail(MergeCoplanar(f).status())->features, (std::vector<FeatureId>{3, 4}));
  f.back() = Feature::Polygon(4, {{1, 2, 9}});
  EXPECT_EQ(refused(f), "polygon 4 has the corner 9, which is no point; add it");
  EXPECT_EQ(GetErrorDetail(MergeCoplanar(f).status())->features, std::vector<FeatureId>{4});
  f.back() = Feature::Polygon(4, {{1, 2}});
  EXPECT_EQ(refused(f), "polygon 4 has a ring of fewer than 3 corners");
  f.back() = Feature::Polygon(4, {});
  EXPECT_EQ(refused(f), "polygon 4 has no ring");
  EXPECT_EQ(refused({}, -1), "the tolerance of coplanar faces must be 0 or more");
  EXPECT_EQ(refused({}, std::nan("")), "the tolerance of coplanar faces must be 0 or more");
}

}  // namespace
}  // namespace dynmesh::coplanar
