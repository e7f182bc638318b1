// Rings in planes in 3D, projected along axes: against sums of angles, and against their
// construction.
#include "core/coplanar/facet_rings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "tests/support/seed.h"

namespace dynmesh::coplanar {
namespace {

using geometry::Point2;
using geometry::Point3;

std::mt19937 NewRandom() { return std::mt19937(test::NewSeed()); }

// In the plane z = 2 x - 3 y + 1, which is parallel to no axis. Exact for small whole numbers.
Point3 Lift(double x, double y) { return {{x, y, 2 * x - 3 * y + 1}}; }

// A simple ring around a place, counter-clockwise in x and y: corners by angle, with no gap of half
// a turn.
PointRing Star(std::mt19937& rng, int x, int y, int size) {
  std::uniform_int_distribution<int> number(-size, size);
  const auto angle = [](const std::pair<int, int>& d) { return std::atan2(d.second, d.first); };
  for (;;) {
    std::vector<std::pair<int, int>> spokes;
    while (spokes.size() < 9) {
      const int dx = number(rng), dy = number(rng);
      if (dx != 0 || dy != 0) spokes.emplace_back(dx, dy);
    }
    std::sort(spokes.begin(), spokes.end(),
              [&](const auto& a, const auto& b) { return angle(a) < angle(b); });
    const auto turns_left = [&](std::size_t i) {
      const auto [ax, ay] = spokes[i];
      const auto [bx, by] = spokes[(i + 1) % spokes.size()];
      return ax * by - ay * bx > 0;
    };
    PointRing ring;
    for (std::size_t i = 0; i < spokes.size() && turns_left(i); ++i) {
      ring.push_back(Lift(x + spokes[i].first, y + spokes[i].second));
    }
    if (ring.size() == spokes.size()) return ring;
  }
}

// The winding number of the ring around the point, by angles; nothing if the point is on it.
std::optional<int> NaiveWinding(const PointRing& ring, const Point3& place) {
  double sum = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point3 &p = ring[i], &q = ring[(i + 1) % ring.size()];
    const double ax = p[0] - place[0], ay = p[1] - place[1];
    const double bx = q[0] - place[0], by = q[1] - place[1];
    const double cross = ax * by - ay * bx, dot = ax * bx + ay * by;
    if (cross == 0 && dot <= 0) return std::nullopt;
    sum += std::atan2(cross, dot);
  }
  return static_cast<int>(std::lround(sum / (2 * std::acos(-1.0))));
}

constexpr AxisView kViews[] = {{0, 1}, {1, 2}, {2, 0}};

TEST(FacetRings, InsideIsWhatRingsGoAroundInEveryView) {
  std::mt19937 rng = NewRandom();
  int inside = 0;
  for (int round = 0; round < 500; ++round) {
    const PointRing ring = Star(rng, 0, 0, 6);
    for (int k = 0; k < 20; ++k) {
      const Point3 place = Lift(static_cast<int>(rng() % 15) - 7, static_cast<int>(rng() % 15) - 7);
      const std::optional<int> winding = NaiveWinding(ring, place);
      if (!winding) continue;
      inside += *winding != 0 ? 1 : 0;
      for (const AxisView view : kViews) {
        ASSERT_EQ(IsInside(ring, place, view), *winding % 2 != 0) << view.first;
      }
    }
  }
  EXPECT_GT(inside, 500);
}

TEST(FacetRings, SignsTurnWithTheRingAndAgreeWithTheArea) {
  std::mt19937 rng = NewRandom();
  for (int round = 0; round < 500; ++round) {
    PointRing ring = Star(rng, 3, -2, 9);
    const auto area = AreaVector(ring);
    if (area[2] == 0) continue;
    for (const AxisView view : kViews) {
      const auto axis = static_cast<std::size_t>(3 - view.first - view.second);
      // Whole numbers of so few digits are exact.
      EXPECT_EQ(SignOf(ring, view), area[axis] > 0 ? 1 : -1);
    }
    const int sign = SignOf(ring, kViews[0]);
    std::rotate(ring.begin(), ring.begin() + 2, ring.end());
    EXPECT_EQ(SignOf(ring, kViews[0]), sign);
    std::reverse(ring.begin(), ring.end());
    EXPECT_EQ(SignOf(ring, kViews[0]), -sign);
  }
}

TEST(FacetRings, ARingOnALineHasNoView) {
  EXPECT_FALSE(ViewOf({Lift(0, 0), Lift(1, 1), Lift(2, 2)}).has_value());
  EXPECT_FALSE(ViewOf({Lift(0, 0), Lift(1, 1)}).has_value());
  EXPECT_FALSE(ViewOf({}).has_value());
  const auto upright = ViewOf({Point3{{0, 0, 0}}, Point3{{0, 1, 0}}, Point3{{0, 0, 1}}});
  ASSERT_TRUE(upright.has_value());
  EXPECT_EQ(upright->first, 1);
  EXPECT_EQ(upright->second, 2);
}

PointRing Square(double x, double y, double half) {
  return {Lift(x - half, y - half), Lift(x + half, y - half), Lift(x + half, y + half),
          Lift(x - half, y + half)};
}

TEST(FacetRings, DepthsCountTheRingsAround) {
  std::mt19937 rng = NewRandom();
  std::vector<std::pair<PointRing, int>> rings = {{Square(0, 0, 9), 0},   {Square(0, 0, 7), 1},
                                                  {Square(3, 3, 3), 2},   {Square(3, 3, 1), 3},
                                                  {Square(-3, -3, 2), 2}, {Square(20, 0, 4), 0}};
  for (int round = 0; round < 50; ++round) {
    std::shuffle(rings.begin(), rings.end(), rng);
    std::vector<PointRing> only;
    std::vector<int> depths;
    for (auto& [ring, depth] : rings) {
      std::rotate(ring.begin(), ring.begin() + rng() % 4, ring.end());
      if (rng() % 2 == 0) std::reverse(ring.begin(), ring.end());
      only.push_back(ring);
      depths.push_back(depth);
    }
    for (const AxisView view : kViews) EXPECT_EQ(DepthsOf(only, view), depths);
  }
}

TEST(FacetRings, ARingThatTouchesInACornerHasADepthInAllOfThemNone) {
  const PointRing outer = {Lift(0, 0), Lift(3, 0), Lift(6, 0), Lift(4, 3), Lift(3, 6), Lift(2, 3)};
  EXPECT_EQ(DepthsOf({outer, {Lift(3, 0), Lift(4, 3), Lift(3, 2)}}, kViews[0]),
            (std::vector<int>{0, 1}));
  EXPECT_EQ(DepthsOf({outer, {Lift(3, 0), Lift(4, 3), Lift(2, 3)}}, kViews[0]), std::nullopt);
}

TEST(FacetRings, TheDomainEndsWhereValidationDoes) {
  EXPECT_TRUE(IsInDomain({0, -0x1p200, 0x1p-200}));
  EXPECT_FALSE(IsInDomain({0, 0x1.1p200, 0}));
  EXPECT_FALSE(IsInDomain({0, 0, -0x1p-201}));
}

}  // namespace
}  // namespace dynmesh::coplanar
