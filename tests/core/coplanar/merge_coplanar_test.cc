// Solids cut into random triangles must be merged to their original faces, and random cells of a
// grid must match an oracle that examines every cell.
#include "core/coplanar/merge_coplanar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/options.h"
#include "tests/core/coplanar/face_soup.h"

namespace dynmesh::coplanar {
namespace {

using testing::FaceSoup;
using testing::Place;
using testing::Shape;
using testing::ShapeOf;
using testing::ShapesOf;

std::mt19937 NewRandom() {
  const std::uint32_t seed = std::random_device{}();
  std::cout << "seed " << seed << "\n";
  return std::mt19937(seed);
}

// A linear map by small whole numbers: keeps what is coplanar exactly so.
class Shear {
 public:
  explicit Shear(std::mt19937& rng) {
    std::uniform_int_distribution<int> number(-3, 3);
    do {
      for (auto& row : m_) row = {number(rng) * 1.0, number(rng) * 1.0, number(rng) * 1.0};
    } while (Det() == 0);
  }
  Place operator()(const Place& p) const {
    Place q{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) q[i] += m_[i][j] * p[j];
    }
    return q;
  }

 private:
  double Det() const {
    return m_[0][0] * (m_[1][1] * m_[2][2] - m_[1][2] * m_[2][1]) -
           m_[0][1] * (m_[1][0] * m_[2][2] - m_[1][2] * m_[2][0]) +
           m_[0][2] * (m_[1][0] * m_[2][1] - m_[1][1] * m_[2][0]);
  }
  std::array<std::array<double, 3>, 3> m_{};
};

using Outline = std::vector<std::array<double, 2>>;

// A prism of height 2 over 2D triangles, and its faces. `rings` are around the triangles and have
// no straight corners.
struct Prism {
  FaceSoup soup;
  std::multiset<Shape> faces;
};
Prism MakePrism(const std::vector<Outline>& rings,
                const std::vector<std::array<std::size_t, 3>>& triangles) {
  Prism prism;
  Shape low, high;
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  for (const Outline& ring : rings) {
    const std::size_t first = prism.soup.points.size() / 2;
    low.emplace_back();
    high.emplace_back();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const auto& [x, y] = ring[i];
      prism.soup.points.push_back({x, y, 0});
      prism.soup.points.push_back({x, y, 2});
      low.back().push_back({x, y, 0});
      high.back().push_back({x, y, 2});
      edges.emplace_back(first + i, first + (i + 1) % ring.size());
    }
  }
  prism.faces = {ShapeOf(low), ShapeOf(high)};
  for (const auto& [a, b] : edges) {
    prism.soup.AddQuad(2 * a, 2 * b, 2 * b + 1, 2 * a + 1);
    const auto& p = prism.soup.points;
    prism.faces.insert(ShapeOf({{p[2 * a], p[2 * b], p[2 * b + 1], p[2 * a + 1]}}));
  }
  for (const auto& [a, b, c] : triangles) {
    prism.soup.faces.push_back({2 * a, 2 * b, 2 * c});
    prism.soup.faces.push_back({2 * a + 1, 2 * b + 1, 2 * c + 1});
  }
  return prism;
}

void ExpectComesBack(const Prism& prism) {
  std::mt19937 rng = NewRandom();
  for (int round = 0; round < 60; ++round) {
    FaceSoup soup = prism.soup;
    soup.Cut(round, rng);
    const Shear shear(rng);
    for (Place& p : soup.points) p = shear(p);
    soup.Shuffle(rng);
    std::multiset<Shape> expected;
    std::set<Place> corners;
    for (const Shape& face : prism.faces) {
      Shape moved = face;
      for (auto& ring : moved) {
        for (Place& p : ring) corners.insert(p = shear(p));
      }
      expected.insert(ShapeOf(std::move(moved)));
    }
    const auto merged = MergeCoplanar(soup.Features());
    ASSERT_TRUE(merged.ok()) << merged.status();
    ASSERT_EQ(ShapesOf(*merged), expected) << round;
    EXPECT_EQ(merged->size(), corners.size() + expected.size()) << "points or segments too many";
    const auto again = MergeCoplanar(*merged);
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(*again, *merged);
  }
}

TEST(MergeCoplanar, ABoxHasSixRectangles) {
  ExpectComesBack(MakePrism({{{0, 0}, {3, 0}, {3, 5}, {0, 5}}}, {{0, 1, 2}, {0, 2, 3}}));
}

TEST(MergeCoplanar, AnLHasTwoHexagonsAndSixRectangles) {
  ExpectComesBack(MakePrism({{{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}}},
                            {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}));
}

TEST(MergeCoplanar, ATunnelIsAHoleInTwoFaces) {
  ExpectComesBack(MakePrism(
      {{{0, 0}, {8, 0}, {8, 8}, {0, 8}}, {{2, 3}, {5, 3}, {5, 6}, {2, 6}}},
      {{0, 1, 4}, {1, 4, 5}, {1, 2, 5}, {2, 5, 6}, {2, 3, 6}, {3, 6, 7}, {3, 0, 7}, {0, 7, 4}}));
}

TEST(MergeCoplanar, TwoTunnelsAreTwoHoles) {
  ExpectComesBack(MakePrism(
      {{{0, 0}, {8, 0}, {8, 8}, {0, 8}}, {{2, 2}, {6, 2}, {4, 6}}, {{4, 7}, {5, 7}, {5, 7.5}}},
      {{0, 1, 4},
       {1, 4, 5},
       {1, 2, 5},
       {2, 5, 6},
       {2, 6, 8},
       {2, 8, 9},
       {2, 9, 3},
       {3, 9, 7},
       {3, 7, 6},
       {6, 7, 8},
       {3, 6, 4},
       {3, 0, 4}}));
}

TEST(MergeCoplanar, HolesThatTouchAreRingsThatTouch) {
  FaceSoup soup;
  for (int x = 0; x <= 4; ++x) {
    for (int y = 0; y <= 4; ++y) soup.points.push_back({x * 1.0, y * 1.0, 7});
  }
  const std::set<std::size_t> out = {6, 12};  // the cells at (1, 1) and (2, 2)
  for (std::size_t x = 0; x < 4; ++x) {
    for (std::size_t y = 0; y < 4; ++y) {
      const std::size_t a = 5 * x + y;
      if (!out.contains(a)) soup.AddQuad(a, a + 5, a + 6, a + 1);
    }
  }
  const auto square = [](double lo, double hi) {
    return std::vector<Place>{{lo, lo, 7}, {lo, hi, 7}, {hi, hi, 7}, {hi, lo, 7}};
  };
  const auto merged = MergeCoplanar(soup.Features());
  ASSERT_TRUE(merged.ok());
  EXPECT_EQ(ShapesOf(*merged),
            (std::multiset<Shape>{ShapeOf({square(0, 4), square(1, 2), square(2, 3)})}));
  EXPECT_EQ(merged->back().rings[0], (std::vector<FeatureId>{1, 5, 25, 21}));  // the outer one
}

// Cells of a grid, some taken out: components, holes, holes that touch, islands.
class Cells {
 public:
  static constexpr int kSide = 7;

  explicit Cells(std::mt19937& rng) : shear_(rng) {
    for (auto& row : there_) {
      for (bool& cell : row) cell = rng() % 100 < 68;
    }
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        if (!At(x, y)) continue;
        const std::size_t a = Point(x, y), b = Point(x + 1, y);
        const std::size_t c = Point(x + 1, y + 1), d = Point(x, y + 1);
        rng() % 2 == 0 ? soup_.AddQuad(a, b, c, d) : soup_.AddQuad(b, c, d, a);
      }
    }
    if (!soup_.faces.empty()) soup_.Cut(static_cast<int>(rng() % 40), rng);
    flat_ = soup_.points;
    for (Place& p : soup_.points) p = shear_(p);
    for (std::size_t i = 0; i < flat_.size(); ++i) flat_at_[soup_.points[i]] = flat_[i];
    soup_.Shuffle(rng);
  }

  const FaceSoup& soup() const { return soup_; }

  using CellSet = std::set<std::pair<int, int>>;

  // The connected sets across edges.
  std::multiset<CellSet> Components() const {
    std::multiset<CellSet> components;
    CellSet seen;
    const std::function<void(int, int, CellSet&)> visit = [&](int x, int y, CellSet& into) {
      if (!At(x, y) || !seen.emplace(x, y).second) return;
      into.emplace(x, y);
      visit(x + 1, y, into), visit(x - 1, y, into), visit(x, y + 1, into), visit(x, y - 1, into);
    };
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        CellSet component;
        visit(x, y, component);
        if (!component.empty()) components.insert(component);
      }
    }
    return components;
  }

  // The cells with midpoints that have an odd number of the shape's vertical edges to their right.
  CellSet Inside(const Shape& shape) const {
    CellSet inside;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        int crossings = 0;
        for (const auto& ring : shape) {
          for (std::size_t i = 0; i < ring.size(); ++i) {
            const Place p = flat_at_.at(ring[i]), q = flat_at_.at(ring[(i + 1) % ring.size()]);
            EXPECT_TRUE(p[0] == q[0] || p[1] == q[1]);
            if (p[0] > x + 0.5 && (p[1] > y + 0.5) != (q[1] > y + 0.5)) ++crossings;
          }
        }
        if (crossings % 2 == 1) inside.emplace(x, y);
      }
    }
    return inside;
  }

 private:
  bool At(int x, int y) const {
    return x >= 0 && y >= 0 && x < kSide && y < kSide &&
           there_[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)];
  }

  std::size_t Point(int x, int y) {
    const auto [it, fresh] = point_.try_emplace({x, y}, soup_.points.size());
    if (fresh) soup_.points.push_back({x * 1.0, y * 1.0, 0});
    return it->second;
  }

  Shear shear_;
  std::array<std::array<bool, kSide>, kSide> there_{};
  FaceSoup soup_;
  std::map<std::pair<int, int>, std::size_t> point_;
  std::vector<Place> flat_;
  std::map<Place, Place> flat_at_;
};

// No duplicates in a polygon, and no straight corner that only one ring has.
void ExpectClean(const std::vector<Feature>& merged) {
  std::map<FeatureId, int> uses;
  std::map<FeatureId, Place> at;
  for (const Feature& f : merged) {
    if (f.kind == FeatureKind::kPoint) at[f.id] = f.position;
    for (const auto& ring : f.rings) {
      for (const FeatureId id : ring) ++uses[id];
    }
  }
  EXPECT_EQ(uses.size(), at.size()) << "a point that nothing names";
  for (const Feature& f : merged) {
    std::set<std::pair<FeatureId, FeatureId>> edges;
    for (const auto& ring : f.rings) {
      EXPECT_EQ(std::set(ring.begin(), ring.end()).size(), ring.size());
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const FeatureId p = ring[i], q = ring[(i + 1) % ring.size()];
        const FeatureId r = ring[(i + 2) % ring.size()];
        EXPECT_TRUE(edges.insert(std::minmax(p, q)).second);
        if (uses[q] > 1) continue;
        const Place a = at[p], b = at[q], c = at[r];
        double cross = 0;
        for (std::size_t d = 0; d < 3; ++d) {
          const std::size_t e = (d + 1) % 3;
          cross += std::abs((b[d] - a[d]) * (c[e] - b[e]) - (b[e] - a[e]) * (c[d] - b[d]));
        }
        EXPECT_NE(cross, 0) << "a straight corner";
      }
    }
  }
}

TEST(MergeCoplanar, CellsOfAGridBecomeTheirComponents) {
  std::mt19937 rng = NewRandom();
  std::size_t most_rings = 0;
  for (int round = 0; round < 200; ++round) {
    const Cells cells(rng);
    const auto merged = MergeCoplanar(cells.soup().Features());
    ASSERT_TRUE(merged.ok()) << merged.status();
    std::multiset<Cells::CellSet> found;
    for (const Shape& shape : ShapesOf(*merged)) {
      found.insert(cells.Inside(shape));
      most_rings = std::max(most_rings, shape.size());
    }
    ASSERT_EQ(found, cells.Components()) << round;
    ExpectClean(*merged);
    FaceSoup shuffled = cells.soup();
    shuffled.Shuffle(rng);
    const auto other = MergeCoplanar(shuffled.Features());
    ASSERT_TRUE(other.ok());
    EXPECT_EQ(ShapesOf(*other), ShapesOf(*merged));
  }
  EXPECT_GT(most_rings, 2U);
}

std::vector<Feature> Points(const std::vector<Place>& places) {
  FaceSoup soup;
  soup.points = places;
  return soup.Features();
}

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

std::vector<Feature> Merged(const std::vector<Feature>& features, double tolerance = 0) {
  const auto merged = MergeCoplanar(features, tolerance);
  EXPECT_TRUE(merged.ok()) << merged.status();
  return merged.ok() ? *merged : std::vector<Feature>();
}

std::vector<Feature> Without(std::vector<Feature> features, const std::set<FeatureId>& ids) {
  std::erase_if(features, [&](const Feature& f) { return ids.contains(f.id); });
  return features;
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

std::vector<Feature> With(std::vector<Feature> features, const std::vector<Rings>& faces) {
  for (const Rings& rings : faces) {
    features.push_back(Feature::Polygon(features.size() + 1, rings));
  }
  return features;
}

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
  f.back() = Feature::Polygon(4, {{1, 2, 9}});
  EXPECT_EQ(refused(f), "polygon 4 has the corner 9, which is no point; add it");
  f.back() = Feature::Polygon(4, {{1, 2}});
  EXPECT_EQ(refused(f), "polygon 4 has a ring of fewer than 3 corners");
  f.back() = Feature::Polygon(4, {});
  EXPECT_EQ(refused(f), "polygon 4 has no ring");
  EXPECT_EQ(refused({}, -1), "the tolerance of coplanar faces must be 0 or more");
  EXPECT_EQ(refused({}, std::nan("")), "the tolerance of coplanar faces must be 0 or more");
}

}  // namespace
}  // namespace dynmesh::coplanar
