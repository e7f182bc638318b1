#include "client/preparation/open_loops.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "client/preparation/open_edges.h"
#include "core/base/feature_kinds.h"
#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"

namespace dynmesh::preparation {
namespace {

// A unit sphere of latitudes and longitudes.
test::Solid Sphere(std::size_t rows, std::size_t columns) {
  test::Solid solid;
  solid.points = {{0, 0, 1}, {0, 0, -1}};
  for (std::size_t i = 1; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j) {
      const double polar = std::numbers::pi * static_cast<double>(i) / static_cast<double>(rows);
      const double around =
          2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(columns);
      solid.points.push_back({std::sin(polar) * std::cos(around),
                              std::sin(polar) * std::sin(around), std::cos(polar)});
    }
  }
  const auto at = [&](std::size_t i, std::size_t j) {
    return i == 0 ? 0 : i == rows ? 1 : 2 + (i - 1) * columns + j % columns;
  };
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j) {
      if (i > 0) solid.faces.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rows) solid.faces.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  return solid;
}

TEST(OpenLoops, ABoxWithoutItsLidHasOneAndIsClosedByAPolygon) {
  test::Solid box = test::BoxSolid({0, 0, 0}, {1, 2, 3});
  std::vector<Feature> features = box.Features();
  EXPECT_TRUE(OpenLoopsOf(features).empty());
  box.faces.erase(box.faces.begin() + 2, box.faces.begin() + 4);
  features = box.Features();
  const std::vector<OpenLoop> loops = OpenLoopsOf(features);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].corners.size(), 4U);
  EXPECT_EQ(loops[0].length, 6);
  EXPECT_EQ(loops[0].middle, (cleaning::Point3{0.5, 1, 3}));
  const std::size_t before = features.size();
  EXPECT_EQ(FillLoops(5.99, features), 0U);
  EXPECT_EQ(features.size(), before);
  EXPECT_EQ(FillLoops(6, features), 1U);
  ASSERT_EQ(features.size(), before + 1);
  EXPECT_EQ(features.back().rings.front().size(), 4U);
  EXPECT_TRUE(OpenEdgesOf(features).empty());
}

// Two holes that meet in a corner, and one that is not flat.
TEST(OpenLoops, HolesThatMeetInACornerAreTwo) {
  test::Solid sphere = Sphere(6, 8);
  std::erase_if(sphere.faces, [&](const auto& face) {
    const std::set<std::size_t> corners(face.begin(), face.end());
    // Those at the point 12 of the second latitude, and one at 20, below its neighbour 13.
    return corners.contains(12) || corners == std::set<std::size_t>{20, 21, 28};
  });
  std::vector<Feature> features = sphere.Features();
  const std::vector<OpenLoop> loops = OpenLoopsOf(features);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_EQ(loops[0].corners.size(), 3U);
  EXPECT_EQ(loops[1].corners.size(), 6U);
  EXPECT_LT(loops[0].length, loops[1].length);
  EXPECT_EQ(FillLoops(loops[0].length, features), 1U);
  EXPECT_EQ(OpenLoopsOf(features).size(), 1U);
  EXPECT_EQ(FillLoops(100, features), 1U);
  EXPECT_TRUE(OpenEdgesOf(features).empty());
}

// Its border is the border of what would fill it.
TEST(OpenLoops, OfATriangleIsNotFilled) {
  std::vector<Feature> features = {Feature::Point(1, 0, 0, 0), Feature::Point(2, 1, 0, 0),
                                   Feature::Point(3, 0, 1, 0), Feature::Polygon(4, {{1, 3, 2}})};
  ASSERT_EQ(OpenLoopsOf(features).size(), 1U);
  EXPECT_EQ(FillLoops(100, features), 0U);
  EXPECT_EQ(features.size(), 4U);
}

// Two faces with four open edges: their fill is the other pair of triangles.
TEST(OpenLoops, FacesThatAreThereAreNoFill) {
  std::vector<Feature> features = {
      Feature::Point(1, 0, 0, 0),       Feature::Point(2, 1, 0, 0),
      Feature::Point(3, 0.1, 1, 0),     Feature::Point(4, 1, 1, 0.1),
      Feature::Polygon(5, {{1, 2, 3}}), Feature::Polygon(6, {{2, 4, 3}})};
  EXPECT_EQ(FillLoops(100, features), 1U);
  EXPECT_TRUE(OpenEdgesOf(features).empty());
  ASSERT_EQ(features.size(), 8U);
  for (std::size_t i = 6; i < 8; ++i) {
    const std::set<FeatureId> corners(features[i].rings[0].begin(), features[i].rings[0].end());
    EXPECT_TRUE(corners.contains(1) && corners.contains(4));
  }
}

// A prism over an L without its lid: one polygon closes it, though its corners turn both ways.
TEST(OpenLoops, AFlatHoleThatIsNotConvexIsOnePolygon) {
  std::vector<Feature> features;
  const double places[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (const double z : {0.0, 1.0}) {
    for (const auto& [x, y] : places) {
      features.push_back(Feature::Point(features.size() + 1, x, y, z));
    }
  }
  features.push_back(Feature::Polygon(20, {{1, 2, 3, 4, 5, 6}}));
  for (FeatureId i = 0; i < 6; ++i) {
    const FeatureId j = (i + 1) % 6;
    features.push_back(Feature::Polygon(21 + i, {{1 + i, 1 + j, 7 + j, 7 + i}}));
  }
  EXPECT_EQ(FillLoops(100, features), 1U);
  EXPECT_EQ(features.back().rings[0].size(), 6U);
  EXPECT_TRUE(OpenEdgesOf(features).empty());
}

// Where three faces have an edge, chains of open edges end that are no loops.
TEST(OpenLoops, OpenEdgesNeedNotBeInLoops) {
  test::Solid box = test::BoxSolid({0, 0, 0}, {1, 1, 1});
  box.points.push_back({2, 2, 0.5});
  box.faces.push_back({3, 7, 8});  // at an edge of the box
  EXPECT_TRUE(OpenLoopsOf(box.Features()).empty());
  box.faces.erase(box.faces.begin());
  const std::vector<OpenLoop> loops = OpenLoopsOf(box.Features());
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].corners.size(), 3U);
}

// Holes at random: closed after filling, whatever the order of points and faces.
TEST(OpenLoops, FillingClosesASphereWithHolesWhateverTheOrder) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    test::Solid sphere = Sphere(5 + random() % 4, 5 + random() % 8);
    const std::size_t gone = 1 + random() % 8;
    std::shuffle(sphere.faces.begin(), sphere.faces.end(), random);
    sphere.faces.resize(sphere.faces.size() - gone);
    // As written, and with other numbers, orders and orientations.
    std::vector<std::vector<std::vector<cleaning::Point3>>> results;
    for (int round = 0; round < 2; ++round) {
      std::vector<Feature> features = sphere.Features();
      const std::size_t loops = OpenLoopsOf(features).size();
      EXPECT_GT(loops, 0U);
      EXPECT_EQ(FillLoops(1e9, features), loops);
      EXPECT_TRUE(OpenEdgesOf(features).empty());
      std::vector<std::vector<cleaning::Point3>> faces;
      for (const Feature& f : features) {
        if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
        std::vector<cleaning::Point3> corners;
        for (const FeatureId id : f.rings.front()) corners.push_back(features[id - 1].position);
        std::ranges::sort(corners);
        faces.push_back(corners);
      }
      std::ranges::sort(faces);
      results.push_back(faces);
      std::vector<std::size_t> order(sphere.points.size());
      for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
      std::shuffle(order.begin(), order.end(), random);
      test::Solid other;
      other.points.resize(order.size());
      for (std::size_t i = 0; i < order.size(); ++i) other.points[order[i]] = sphere.points[i];
      for (const auto& [a, b, c] : sphere.faces)
        other.faces.push_back({order[b], order[a], order[c]});
      std::shuffle(other.faces.begin(), other.faces.end(), random);
      sphere = other;
    }
    EXPECT_EQ(results[0], results[1]);
  }
}

}  // namespace
}  // namespace dynmesh::preparation
