#include "client/cleaning/feature_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "tests/client/cleaning/surface_oracle.h"
#include "tests/client/cleaning/test_surfaces.h"

namespace dynmesh::cleaning {
namespace {

FeatureEdgeOptions Options(double angle, double within) {
  FeatureEdgeOptions options;
  options.angle = angle;
  options.within = within;
  options.tolerance = 1e-10;
  return options;
}

std::size_t CountOf(const std::vector<Feature>& features, FeatureKind kind) {
  std::size_t count = 0;
  for (const Feature& f : features) count += f.kind == kind ? 1 : 0;
  return count;
}

// By length of edges' lists of faces.
std::map<std::size_t, std::size_t> EdgesByFaces(const std::vector<Feature>& features) {
  std::map<std::set<Place3>, std::size_t> edges;
  for (const auto& t : PlainOf(features).triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  std::map<std::size_t, std::size_t> counts;
  for (const auto& [edge, count] : edges) ++counts[count];
  return counts;
}

TEST(FeatureEdges, ACubeOfManyTrianglesGetsItsTwelve) {
  for (const int n : {1, 2, 3, 4, 7, 8, 13}) {
    SCOPED_TRACE(n);
    SurfaceMaker maker;
    maker.AddCube(n);
    const std::vector<Feature> input = maker.Features();
    const auto kept = KeepFeatureEdges(input, Options(30, 1e-3));
    ASSERT_TRUE(kept.ok()) << kept.status();
    EXPECT_EQ(CountOf(kept->features, FeatureKind::kPoint), 8U);
    EXPECT_EQ(CountOf(kept->features, FeatureKind::kPolygon), 12U);
    EXPECT_EQ(kept->sharp_edges, 12U);
    EXPECT_EQ(kept->corners, 8U);
    EXPECT_EQ(kept->changes.size(), CountOf(input, FeatureKind::kPoint) - 8);
    EXPECT_EQ(FaultOf(PlainOf(kept->features)), "");
    EXPECT_EQ(EdgesByFaces(kept->features), (std::map<std::size_t, std::size_t>{{2, 18}}));
  }
}

TEST(FeatureEdges, ATinyDistanceChangesNothingThatIsCurved) {
  SurfaceMaker maker;
  maker.AddSphere(6);
  const auto kept = KeepFeatureEdges(maker.Features(), Options(30, 1e-9));
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->features, maker.Features());
  EXPECT_TRUE(kept->changes.empty());
  EXPECT_TRUE(kept->parts.empty());
}

TEST(FeatureEdges, ASmallAngleKeepsEveryEdgeOfACurvedSurface) {
  SurfaceMaker maker;
  maker.AddSphere(6);
  const auto kept = KeepFeatureEdges(maker.Features(), Options(0.1, 1));
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->features, maker.Features());
  EXPECT_EQ(kept->sharp_edges, maker.face_count() * 3 / 2);
}

TEST(FeatureEdges, BordersBetweenGroupsStay) {
  // A square of 8 x 8, its left part of x < 3 of another group.
  SurfaceMaker maker;
  FeatureEdgeOptions options = Options(30, 100);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      const double x = i, y = j;
      maker.AddQuadrangle({x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0});
    }
  }
  const std::vector<Feature> input = maker.Features();
  const FeatureId first = CountOf(input, FeatureKind::kPoint) + 1;
  std::set<FeatureId> inner;
  for (FeatureId k = 0; k < 3 * 8 * 2; ++k) inner.insert(first + k);
  options.group = [&](FeatureId id) { return inner.contains(id) ? 1 : 0; };
  const auto kept = KeepFeatureEdges(input, options);
  ASSERT_TRUE(kept.ok()) << kept.status();
  // Both rectangles, of two triangles each.
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kPoint), 6U);
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kPolygon), 4U);
  std::map<FeatureId, Place3> at;
  for (const Feature& f : kept->features) {
    if (f.kind == FeatureKind::kPoint) at[f.id] = f.position;
    if (f.kind != FeatureKind::kPolygon) continue;
    for (const FeatureId corner : f.rings[0]) {
      EXPECT_TRUE(inner.contains(f.id) ? at.at(corner)[0] <= 3 : at.at(corner)[0] >= 3);
    }
  }
}

TEST(FeatureEdges, ABorderBetweenGroupsInAPlaneStaysWithinTheDistance) {
  // A disc of radius 1 in a ring of radius 2; the surface is flat, only the circle between bends.
  constexpr int kSides = 96;
  SurfaceMaker maker;
  FeatureEdgeOptions options = Options(60, 0.02);
  const auto at = [](int i, double radius) {
    const double angle = 2 * std::numbers::pi * (i % kSides) / kSides;
    return SurfaceMaker::Place{radius * std::cos(angle), radius * std::sin(angle), 0};
  };
  for (int i = 0; i < kSides; ++i) maker.AddTriangle(at(i, 0.9), at(i + 1, 0.9), {0, 0, 0});
  for (const double radius : {0.9, 1.0, 1.5}) {
    for (int i = 0; i < kSides; ++i) {
      const double outer = radius < 1 ? 1 : radius + 0.5;
      maker.AddQuadrangle(at(i, radius), at(i + 1, radius), at(i + 1, outer), at(i, outer));
    }
  }
  const std::vector<Feature> input = maker.Features();
  const FeatureId first = CountOf(input, FeatureKind::kPoint) + 1;
  std::set<FeatureId> inner;
  for (FeatureId k = 0; k < 3 * kSides; ++k) inner.insert(first + k);
  options.group = [&](FeatureId id) { return inner.contains(id) ? 1 : 0; };
  const auto kept = KeepFeatureEdges(input, options);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_LT(CountOf(kept->features, FeatureKind::kPolygon), maker.face_count() / 2);
  // Edges of the disc's border are between points of the circle: their middles are near it.
  std::map<FeatureId, Place3> places;
  std::map<std::set<FeatureId>, std::set<bool>> groups;
  for (const Feature& f : kept->features) {
    if (f.kind == FeatureKind::kPoint) places[f.id] = f.position;
    if (f.kind != FeatureKind::kPolygon) continue;
    FeatureId whole = f.id;
    for (const auto& [part, of] : kept->parts) whole = part == f.id ? of : whole;
    for (std::size_t k = 0; k < 3; ++k) {
      groups[{f.rings[0][k], f.rings[0][(k + 1) % 3]}].insert(inner.contains(whole));
    }
  }
  std::size_t borders = 0;
  for (const auto& [edge, of] : groups) {
    if (of.size() < 2) continue;
    ++borders;
    const Place3 &a = places.at(*edge.begin()), &b = places.at(*edge.rbegin());
    EXPECT_NEAR(std::hypot(a[0], a[1]), 1, 1e-12);
    EXPECT_GE(std::hypot((a[0] + b[0]) / 2, (a[1] + b[1]) / 2), 1 - 0.02 - 1e-3);
  }
  EXPECT_GT(borders, 10U);
  EXPECT_LT(borders, kSides / 2);
}

TEST(FeatureEdges, SegmentsPointsAndWhatIsNearAnotherSurfaceStay) {
  // Two sheets of 4 x 4 squares, the upper one with a bump that the lower one follows at a distance
  // of less than D; a segment on the border of the lower one, a point between them.
  SurfaceMaker maker;
  for (const double z : {0.0, 0.01}) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const auto at = [&](int a, int b) {
          return SurfaceMaker::Place{double(a), double(b), z + (a == 2 && b == 2 ? 0.05 : 0)};
        };
        maker.AddQuadrangle(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }
  std::vector<Feature> input = maker.Features();
  FeatureId end = kNoFeature, start = kNoFeature;
  for (const Feature& f : input) {
    if (f.kind == FeatureKind::kPoint && f.position == Place3{1, 0, 0}) start = f.id;
    if (f.kind == FeatureKind::kPoint && f.position == Place3{2, 0, 0}) end = f.id;
  }
  const FeatureId segment = input.size() + 1, point = segment + 1;
  input.push_back(Feature::Segment(segment, start, end));
  input.push_back(Feature::Point(point, 2, 2, 0.055));
  const auto kept = KeepFeatureEdges(input, Options(30, 0.2));
  ASSERT_TRUE(kept.ok()) << kept.status();
  const PlainSurface plain = PlainOf(kept->features);
  EXPECT_EQ(FaultOf(plain), "");
  EXPECT_LT(plain.triangles.size(), maker.face_count() / 2);
  const std::set<Place3> points(plain.points.begin(), plain.points.end());
  for (const Place3& p : {Place3{1, 0, 0}, Place3{2, 0, 0}, Place3{2, 2, 0.055}, Place3{4, 4, 0}}) {
    EXPECT_TRUE(points.contains(p));
  }
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kSegment), 1U);
  // The upper sheet may not pass over the point.
  EXPECT_TRUE(points.contains({2, 2, 0.01 + 0.05}));
}

TEST(FeatureEdges, EdgesOfThreeFacesAndOpenOnesStay) {
  // Three half-planes at the z axis.
  SurfaceMaker maker;
  for (const auto& [x, y] : {std::pair(1.0, 0.0), std::pair(-1.0, 1.0), std::pair(-1.0, -1.0)}) {
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k) {
        const auto at = [&, x = x, y = y](int a, int b) {
          return SurfaceMaker::Place{x * a, y * a, double(b)};
        };
        maker.AddQuadrangle(at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1));
      }
    }
  }
  const auto kept = KeepFeatureEdges(maker.Features(), Options(30, 1e-3));
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kPolygon), 6U);
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kPoint), 8U);
  EXPECT_EQ(EdgesByFaces(kept->features),
            (std::map<std::size_t, std::size_t>{{1, 9}, {2, 3}, {3, 1}}));
}

TEST(FeatureEdges, CubesThatMeetInAnEdgeOrACornerStay) {
  // In a corner, then at (4, 0, 0) - (4, 0, 4) in an edge with a third one.
  SurfaceMaker maker;
  maker.AddCube(4);
  maker.AddCube(3, 4);
  const auto kept = KeepFeatureEdges(maker.Features(), Options(30, 1e-3));
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kPolygon), 24U);
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kPoint), 15U);
  EXPECT_EQ(EdgesByFaces(kept->features), (std::map<std::size_t, std::size_t>{{2, 36}}));
}

TEST(FeatureEdges, APolygonThatNothingChangesStaysOne) {
  std::vector<Feature> input = {Feature::Point(1, 0, 0, 0), Feature::Point(2, 2, 0, 0),
                                Feature::Point(3, 2, 2, 0), Feature::Point(4, 0, 2, 0),
                                Feature::Polygon(5, {{3, 4, 1, 2}})};
  auto kept = KeepFeatureEdges(input, Options(30, 1e-3));
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(kept->features, input);
  // With a point amid a side it becomes triangles, with the ids 5 and 7.
  input = {input[0],
           input[1],
           input[2],
           input[3],
           Feature::Point(6, 1, 0, 0),
           Feature::Polygon(5, {{1, 6, 2, 3, 4}})};
  kept = KeepFeatureEdges(input, Options(30, 1e-3));
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_EQ(CountOf(kept->features, FeatureKind::kPoint), 4U);
  EXPECT_EQ(kept->parts, (std::vector<std::pair<FeatureId, FeatureId>>{{7, 5}}));
  ASSERT_EQ(kept->changes.size(), 1U);
  EXPECT_EQ(kept->changes[0].ids, std::vector<FeatureId>{6});
}

TEST(FeatureEdges, ValuesOutOfRangeAreRefused) {
  for (const double angle : {0.0, -1.0, 0.05, 89.5, 0.0 / 0.0}) {
    EXPECT_TRUE(absl::IsInvalidArgument(KeepFeatureEdges({}, Options(angle, 1)).status())) << angle;
  }
  for (const double within : {0.0, -1.0, 1.0 / 0.0, 0.0 / 0.0}) {
    EXPECT_TRUE(absl::IsInvalidArgument(KeepFeatureEdges({}, Options(30, within)).status()));
  }
  EXPECT_TRUE(KeepFeatureEdges({}, Options(30, 1)).ok());
  EXPECT_EQ(DefaultWithin({}), 0);
  SurfaceMaker maker;
  maker.AddCube(2);
  EXPECT_DOUBLE_EQ(DefaultWithin(maker.Features()), 0.002 * std::sqrt(3.0));
}

}  // namespace
}  // namespace dynmesh::cleaning
