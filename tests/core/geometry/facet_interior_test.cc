// Insides of polygons: the tree against one pass over all edges, for any number of edges, with
// equal heights, and for any form of the rings.
#include "core/geometry/facet_interior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::geometry::facet_interior_test {
namespace {

constexpr std::uint64_t kSeed = 20261122;
constexpr double kTurn = 6.283185307179586;

using Ring2 = std::vector<Point2>;

// A plane in 3D to draw in.
struct Sheet {
  Point3 origin;
  Vector3 u, v;

  Point3 At(const Point2& p) const {
    Point3 at = origin;
    for (int k = 0; k < 3; ++k) at[k] += p[0] * u[k] + p[1] * v[k];
    return at;
  }
  Vector3 Along(const Point2& d) const {
    return {d[0] * u[0] + d[1] * v[0], d[0] * u[1] + d[1] * v[1], d[0] * u[2] + d[1] * v[2]};
  }
  std::vector<Ring3> Draw(const std::vector<Ring2>& rings) const {
    std::vector<Ring3> drawn;
    for (const Ring2& ring : rings) {
      drawn.emplace_back();
      for (const Point2& p : ring) drawn.back().push_back(At(p));
    }
    return drawn;
  }
};

// Axis-parallel; turned by less than rounding; arbitrary.
std::vector<Sheet> Sheets(test::Random& random) {
  std::vector<Sheet> sheets = {{{{0, 0, 2}}, {1, 0, 0}, {0, 1, 0}},
                               {{{3, 0, 0}}, {0, 0, 1}, {0, 1, 0}},
                               {{{0, 0, 2}}, {1, 3e-16, 0}, {-3e-16, 1, 0}},
                               {{{0, 0, 2}}, {0.6, 0.8, 0}, {-0.8, 0.6, 0}}};
  for (int i = 0; i < 4; ++i) {
    const Vector3 n = {random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5};
    Vector3 u = Cross(n, {0.3, 0.5, 0.7}), v = Cross(n, u);
    const double nu = std::sqrt(Dot(u, u)), nv = std::sqrt(Dot(v, v));
    for (int k = 0; k < 3; ++k) u[k] /= nu, v[k] /= nv;
    sheets.push_back({{{5, 5, 5}}, u, v});
  }
  return sheets;
}

// Star-shaped rings, one within the other.
std::vector<Ring2> Stars(test::Random& random, int corners) {
  std::vector<Ring2> rings;
  for (const double size : {10.0, 6.0, 3.0}) {
    Ring2& ring = rings.emplace_back();
    for (int i = 0; i < corners; ++i) {
      const double turn = kTurn * (i + 0.5 * random.Unit()) / corners;
      const double r = size * (0.7 + 0.3 * random.Unit());
      ring.push_back({{r * std::cos(turn), r * std::sin(turn)}});
    }
  }
  return rings;
}

// A comb with all teeth over the same heights, or a stair: right angles, many equal heights.
Ring2 Comb(int teeth) {
  Ring2 ring = {{{0, -1}}};
  for (int i = 0; i < teeth; ++i) {
    const double x = i;
    ring.insert(ring.end(), {{{x, 8}}, {{x + 0.5, 8}}, {{x + 0.5, 0}}, {{x + 1, 0}}});
  }
  ring.push_back({{static_cast<double>(teeth), -1}});
  return ring;
}
Ring2 Stair(int steps) {
  Ring2 ring;
  for (int i = 0; i < steps; ++i) {
    const double x = i;
    ring.insert(ring.end(), {{{x, x}}, {{x + 1, x}}});
  }
  ring.push_back({{static_cast<double>(steps), static_cast<double>(steps)}});
  ring.push_back({{0, static_cast<double>(steps)}});
  return ring;
}

// Squares on a lattice, each with one inside it that touches it at a corner.
std::vector<Ring2> Lattice(int side) {
  std::vector<Ring2> rings;
  const auto add = [&](double x, double y, double size) {
    rings.push_back({{{x, y}}, {{x + size, y}}, {{x + size, y + size}}, {{x, y + size}}});
  };
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      add(i, j, 0.75);
      rings.push_back({{{i + 0.0, j + 0.0}}, {{i + 0.5, j + 0.25}}, {{i + 0.25, j + 0.5}}});
    }
  }
  return rings;
}

std::vector<std::vector<Ring2>> Polygons(test::Random& random) {
  return {Stars(random, 5),   Stars(random, 40),
          Stars(random, 300), {Comb(5)},
          {Comb(100)},        {Stair(6)},
          {Stair(200)},       Lattice(2),
          Lattice(9),         {{{{0, 0}}, {{1, 0}}, {{0, 1}}}}};
}

bool NaiveHolds(const std::vector<Ring3>& rings, const FacetPlane& plane, const Point3& p) {
  const int x = (plane.axis + 1) % 3, y = (plane.axis + 2) % 3;
  bool inside = false;
  for (const Ring3& ring : rings) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const Point3 &a = std::min(ring[i], ring[j]), &b = std::max(ring[i], ring[j]);
      if ((a[y] > p[y]) == (b[y] > p[y])) continue;
      inside ^= p[x] - a[x] < (b[x] - a[x]) * ((p[y] - a[y]) / (b[y] - a[y]));
    }
  }
  return inside;
}

class FacetInteriors : public ::testing::Test {
 protected:
  // f(sheet, drawn, rings, plane, interior) for all polygons on all sheets.
  template <class F>
  void ForEach(F f) {
    test::Random random(kSeed);
    const auto sheets = Sheets(random);
    const auto polygons = Polygons(random);
    for (std::size_t i = 0; i < polygons.size(); ++i) {
      for (std::size_t j = 0; j < sheets.size(); ++j) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", polygon " + std::to_string(i) +
                     " on sheet " + std::to_string(j));
        const auto rings = sheets[j].Draw(polygons[i]);
        const FacetPlane plane = PlaneOf(rings);
        f(random, sheets[j], polygons[i], rings, plane, FacetInterior(rings, plane));
      }
    }
  }
};

TEST_F(FacetInteriors, HoldWhatIsInside) {
  int inside = 0, outside = 0;
  ForEach([&](test::Random& random, const Sheet& sheet, const auto& drawn, const auto& rings,
              const FacetPlane& plane, const FacetInterior& interior) {
    Point2 lo = drawn[0][0], hi = lo;
    for (const Ring2& ring : drawn) {
      for (const Point2& p : ring) {
        for (int k = 0; k < 2; ++k) lo[k] = std::min(lo[k], p[k]), hi[k] = std::max(hi[k], p[k]);
      }
    }
    const auto check = [&](const Point2& at) {
      const Point3 p = sheet.At(at);
      const bool wanted = NaiveHolds(rings, plane, p);
      ASSERT_EQ(interior.Holds(p), wanted) << at[0] << ' ' << at[1];
      ++(wanted ? inside : outside);
    };
    for (int i = 0; i < 400; ++i) {
      check({{lo[0] - 0.1 + random.Unit() * (hi[0] - lo[0] + 0.2),
              lo[1] - 0.1 + random.Unit() * (hi[1] - lo[1] + 0.2)}});
    }
    // At heights of corners, and by their sides.
    for (const Ring2& ring : drawn) {
      const Point2& c = ring[random.Below(static_cast<int>(ring.size()))];
      check({{lo[0] + random.Unit() * (hi[0] - lo[0]), c[1]}});
      check({{c[0], lo[1] + random.Unit() * (hi[1] - lo[1])}});
    }
  });
  EXPECT_GT(inside, 5'000);
  EXPECT_GT(outside, 5'000);
}

// The direction of a corner's opening is tested a little way off, if that is not near an edge.
TEST_F(FacetInteriors, OpenFromCorners) {
  int opens = 0, shut = 0;
  ForEach([&](test::Random& random, const Sheet& sheet, const auto& drawn, const auto& rings,
              const FacetPlane& plane, const FacetInterior& interior) {
    for (const Ring2& ring : drawn) {
      for (const Point2& c : ring) {
        if (drawn[0].size() > 20 && !random.OneIn(4)) continue;
        for (int turns = 0; turns < 8; ++turns) {
          Point2 d = {{std::cos(kTurn * turns / 8), std::sin(kTurn * turns / 8)}};
          if (random.OneIn(2)) d = {{random.Unit() - 0.5, random.Unit() - 0.5}};
          const double step = 1e-7 / std::hypot(d[0], d[1]), aside = 1e-3 * step;
          const auto near = [&](double side) {
            return NaiveHolds(rings, plane,
                              sheet.At({{c[0] + step * d[0] - side * aside * d[1],
                                         c[1] + step * d[1] + side * aside * d[0]}}));
          };
          const bool wanted = near(0);
          if (near(-1) != wanted || near(1) != wanted) continue;  // along an edge
          ASSERT_EQ(interior.OpensTo(sheet.At(c), sheet.Along(d)), wanted)
              << c[0] << ' ' << c[1] << " to " << d[0] << ' ' << d[1];
          ++(wanted ? opens : shut);
        }
      }
    }
  });
  EXPECT_GT(opens, 5'000);
  EXPECT_GT(shut, 5'000);
}

TEST_F(FacetInteriors, DoNotDependOnHowRingsAreWritten) {
  ForEach([&](test::Random& random, const Sheet& sheet, const auto& drawn, auto rings,
              const FacetPlane& plane, const FacetInterior& interior) {
    for (Ring3& ring : rings) {
      std::rotate(ring.begin(), ring.begin() + random.Below(static_cast<int>(ring.size())),
                  ring.end());
      if (random.OneIn(2)) std::reverse(ring.begin(), ring.end());
    }
    std::reverse(rings.begin(), rings.end());
    const FacetInterior again(rings, plane);
    for (int i = 0; i < 100; ++i) {
      const Point2& c = drawn[0][random.Below(static_cast<int>(drawn[0].size()))];
      const Point3 p = sheet.At({{c[0] + random.Unit() - 0.5, c[1] + random.Unit() - 0.5}});
      ASSERT_EQ(interior.Holds(p), again.Holds(p));
      ASSERT_EQ(interior.Holds(sheet.At(c)), again.Holds(sheet.At(c)));  // an arbitrary answer
      const Vector3 d = sheet.Along({{random.Unit() - 0.5, random.Unit() - 0.5}});
      ASSERT_EQ(interior.OpensTo(sheet.At(c), d), again.OpensTo(sheet.At(c), d));
    }
  });
}

TEST(FacetInterior, IsEvenOdd) {
  const auto square = [](double lo, double hi) {
    return Ring3{{{lo, lo, 2}}, {{hi, lo, 2}}, {{hi, hi, 2}}, {{lo, hi, 2}}};
  };
  const std::vector<Ring3> rings = {square(0, 8), square(1, 7), square(3, 5)};
  const FacetInterior interior(rings, PlaneOf(rings));
  for (const auto& [at, wanted] : {std::pair(-1.0, false),
                                   {0.5, true},
                                   {2.0, false},
                                   {4.0, true},
                                   {6.0, false},
                                   {7.5, true}}) {
    EXPECT_EQ(interior.Holds({{at, 4, 2}}), wanted) << at;
    EXPECT_EQ(interior.Holds({{4, at, 2}}), wanted) << at;
  }
}

// Rings that cross, that have no area, or that contain NaN: any answer, and termination.
TEST(FacetInterior, TakesWhatIsNoPolygon) {
  test::Random random(kSeed);
  std::vector<Ring3> rings(3);
  for (Ring3& ring : rings) {
    for (int i = 0; i < 400; ++i) {
      ring.push_back({{random.Unit(), random.Unit(), static_cast<double>(random.Below(3))}});
    }
  }
  const FacetPlane plane = PlaneOf(rings);
  const FacetInterior interior(rings, plane);
  for (int i = 0; i < 1'000; ++i) interior.Holds({{random.Unit(), random.Unit(), 1}});
  for (const Point3& p : rings[1]) interior.OpensTo(p, {random.Unit() - 0.5, 0.5, 0.25});

  const std::vector<Ring3> line = {Ring3(100, {{1, 2, 3}})};
  const FacetInterior of_line(line, PlaneOf(line));
  EXPECT_FALSE(of_line.Holds({{1, 2, 3}}));
  EXPECT_FALSE(interior.Holds({{NAN, NAN, NAN}}));
  EXPECT_FALSE(FacetInterior().Holds({{0, 0, 0}}));
}

// A million steps of bisection, not a million edges per query.
TEST(FacetInterior, HasManyCorners) {
  constexpr int kTeeth = 100'000;
  const Sheet sheet = {{{0, 0, 0}}, {1, 0, 0}, {0, 1, 0.25}};
  const auto rings = sheet.Draw({Comb(kTeeth)});
  const FacetInterior interior(rings, PlaneOf(rings));
  for (int i = 0; i < kTeeth; ++i) {
    ASSERT_TRUE(interior.Holds(sheet.At({{i + 0.25, 4}}))) << i;
    ASSERT_FALSE(interior.Holds(sheet.At({{i + 0.75, 4}}))) << i;
    ASSERT_TRUE(interior.OpensTo(sheet.At({{i + 0.5, 0}}), sheet.Along({{-1, -2}}))) << i;
    ASSERT_FALSE(interior.OpensTo(sheet.At({{i + 0.5, 0}}), sheet.Along({{1, 2}}))) << i;
  }
}

}  // namespace
}  // namespace dynmesh::geometry::facet_interior_test
