// What others need stays when coplanar faces are merged: points and edges that segments, sizing
// polygons and walls are on.
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/coplanar/merge_coplanar.h"
#include "core/plc/plc.h"
#include "dynmesh/options.h"
#include "tests/core/coplanar/face_soup.h"
#include "tests/core/coplanar/merge_coplanar_util.h"

namespace dynmesh::coplanar {
namespace {

using testing::FaceSoup;
using testing::Shape;
using testing::ShapesOf;

// A square of z = 0 cut so that the edge between 5 and 6 is in its middle.
std::vector<Feature> Floor() {
  std::vector<Feature> f = Points({{0, 0, 0},
                                   {9, 0, 0},
                                   {9, 9, 0},
                                   {0, 9, 0},
                                   {3, 4, 0},
                                   {6, 4, 0},
                                   {3, 4, 2},
                                   {6, 4, 2},
                                   {3, 4, -2},
                                   {6, 4, -2}});
  FeatureId id = 20;
  for (const Rings& rings :
       {Rings{{1, 2, 6, 5}}, Rings{{2, 3, 6}}, Rings{{3, 4, 5, 6}}, Rings{{4, 1, 5}}}) {
    f.push_back(Feature::Polygon(++id, rings));
  }
  return f;
}

TEST(MergeCoplanar, PointsThatNothingNamesAnyMoreGoAndOthersStay) {
  std::vector<Feature> expected = Without(Floor(), {5, 6, 22, 23, 24});
  expected.back() = Feature::Polygon(21, {{1, 4, 3, 2}});
  EXPECT_EQ(Merged(Floor()), expected);  // 7 to 10 were used only there
}

// All of the floor's faces except one, so that 5 and 6 stay on rings, and that one.
std::vector<Feature> FloorOfTwo() {
  std::vector<Feature> f = Without(Floor(), {23, 24});
  f.back() = Feature::Polygon(22, {{1, 4, 3, 2, 6, 5}});
  return f;
}

TEST(MergeCoplanar, SegmentsAndSizingPolygonsKeepTheirPointsOnRings) {
  const std::vector<Feature> others = {Feature::Segment(30, 5, 7),
                                       Feature::SizePolygon(31, {{6, 7, 8}}, 0.5)};
  std::vector<Feature> f = Floor(), expected = FloorOfTwo();
  f.insert(f.end(), others.begin(), others.end());
  expected.insert(expected.end(), others.begin(), others.end());
  EXPECT_EQ(Merged(f), expected);
}

TEST(MergeCoplanar, ASegmentInTheFloorStaysOnRings) {
  std::vector<Feature> f = Floor(), expected = FloorOfTwo();
  for (auto* features : {&f, &expected}) features->push_back(Feature::Segment(30, 5, 6));
  EXPECT_EQ(Merged(f), expected);
}

TEST(MergeCoplanar, AWallInTheFloorStandsOnRings) {
  std::vector<Feature> f = Floor(), expected = FloorOfTwo();
  for (auto* features : {&f, &expected}) {
    features->push_back(Feature::Polygon(30, {{5, 6, 8, 7}}));
  }
  EXPECT_EQ(Merged(f), expected);
}

TEST(MergeCoplanar, WhereTwoWallsCrossTheirEdgeStaysOnRings) {
  std::vector<Feature> f = Floor();
  // A wall through the floor, of two halves that are connected beside the edge as well.
  f.push_back(Feature::Point(11, 2, 4, 1));
  f.push_back(Feature::Point(12, 1, 4, -1));
  f.push_back(Feature::Polygon(30, {{5, 6, 8, 7, 11}}));
  f.push_back(Feature::Polygon(31, {{5, 6, 10, 9, 12}}));
  f.push_back(Feature::Polygon(32, {{5, 11, 12}}));
  const std::vector<Feature> merged = Merged(f);
  const std::multiset<Shape> shapes = ShapesOf(merged);
  EXPECT_EQ(shapes.size(), 4U);
  for (const Shape& shape : ShapesOf(FloorOfTwo())) EXPECT_TRUE(shapes.contains(shape));
  int on_edge = 0;
  for (const Feature& polygon : merged) {
    for (const auto& ring : polygon.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const FeatureId p = ring[i], q = ring[(i + 1) % ring.size()];
        on_edge += std::min(p, q) == 5 && std::max(p, q) == 6 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(on_edge, 4);
}

constexpr std::array<std::size_t, 3> kStep = {1, 4, 16};

// Any of a grid's squares and edges may be present. Merged, they are legal again: nothing is left
// on the inside of a merged square.
TEST(MergeCoplanar, WhatIsLegalStaysLegal) {
  std::mt19937 rng = NewRandom();
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  options.box.hi = {3, 3, 3};
  std::size_t before = 0, after = 0;
  for (int round = 0; round < 150; ++round) {
    FaceSoup soup;
    for (int i = 0; i < 64; ++i)
      soup.points.push_back({i % 4 * 1.0, i / 4 % 4 * 1.0, i / 16 * 1.0});
    const auto can_go = [](std::size_t i, std::size_t axis) { return i / kStep[axis] % 4 < 3; };
    const std::array<std::size_t, 3> share = {rng() % 101, rng() % 101, rng() % 101};
    for (std::size_t i = 0; i < 64; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        if (!can_go(i, u) || !can_go(i, v) || rng() % 100 >= share[axis]) continue;
        soup.faces.push_back({i, i + kStep[u], i + kStep[u] + kStep[v], i + kStep[v]});
      }
    }
    std::vector<Feature> f = soup.Features();
    std::set<std::pair<FeatureId, FeatureId>> segments;
    for (int k = static_cast<int>(rng() % 3); k > 0; --k) {
      const std::size_t i = rng() % 64, axis = rng() % 3;
      if (!can_go(i, axis) || !segments.emplace(i + 1, i + 1 + kStep[axis]).second) continue;
      f.push_back(Feature::Segment(1000 + segments.size(), i + 1, i + 1 + kStep[axis]));
    }
    const auto check = [&](const std::vector<Feature>& features) {
      EditBatch batch;
      for (const Feature& feature : features) batch.push_back(Edit::Add(feature));
      return plc::Plc3(options).Check(batch).status();
    };
    ASSERT_TRUE(check(f).ok()) << check(f);
    const std::vector<Feature> merged = Merged(f);
    ASSERT_TRUE(check(merged).ok()) << round << ": " << check(merged);
    before += soup.faces.size();
    after += ShapesOf(merged).size();
    // The order of faces has no effect.
    if (!segments.empty()) continue;
    soup.Shuffle(rng);
    ASSERT_EQ(ShapesOf(Merged(soup.Features())), ShapesOf(merged));
  }
  EXPECT_LT(after, before * 3 / 4);
}

TEST(MergeCoplanar, AWallAcrossTheFloorDividesIt) {
  std::vector<Feature> f =
      Points({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 3}, {4, 4, 3}});
  f.push_back(Feature::Polygon(7, {{1, 2, 3}}));
  f.push_back(Feature::Polygon(8, {{1, 3, 4}}));
  EXPECT_EQ(Merged(f).size(), 5U + 1U + 1U);  // without the wall
  f.push_back(Feature::Polygon(9, {{1, 3, 6, 5}}));
  EXPECT_EQ(Merged(f), f);
  std::rotate(f.end() - 3, f.end() - 1, f.end());  // the wall first
  EXPECT_EQ(Merged(f), f);
}

}  // namespace
}  // namespace dynmesh::coplanar
