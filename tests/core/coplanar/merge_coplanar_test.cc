// Solids cut into random triangles must be merged to their original faces, and random cells of a
// grid must match an oracle that examines every cell.
#include "core/coplanar/merge_coplanar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "tests/core/coplanar/face_soup.h"
#include "tests/core/coplanar/merge_coplanar_util.h"

namespace dynmesh::coplanar {
namespace {

using testing::FaceSoup;
using testing::Place;
using testing::Shape;
using testing::ShapeOf;
using testing::ShapesOf;

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

}  // namespace
}  // namespace dynmesh::coplanar
