// Counterparts (sharp_facets.h): properties on random triangles with a common edge or corner.
#include "core/meshing/sharp_facets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/constructions.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::sharp_facets_test {
namespace {

using geometry::Point3;
using geometry::SquaredDistance;

constexpr double kDegree = std::numbers::pi / 180;

Facet Triangle(const std::vector<Point3>& points, VertexIndex a, VertexIndex b, VertexIndex c,
               FeatureSlot feature) {
  const std::vector<std::vector<VertexIndex>> rings = {{a, b, c}};
  return Facet(rings, feature, [&](VertexIndex v) { return points[v]; });
}

// A random place in the triangle from the origin to points a and b.
Point3 PlaceIn(const std::vector<Point3>& points, VertexIndex a, VertexIndex b,
               test::Random& random) {
  double x = random.Unit(), y = random.Unit();
  if (x + y > 1) x = 1 - x, y = 1 - y;
  Point3 p;
  for (int k = 0; k < 3; ++k) p[k] = x * points[a][k] + y * points[b][k];
  return p;
}

// Two triangles over the edge from 0 to 1, at `angle`; the corners 2 and 3.
struct Wedge {
  explicit Wedge(double angle, test::Random& random) {
    const auto third = [&](double turn) {
      const double x = random.Unit(), r = 0.5 + random.Unit();
      return Point3{{x, r * std::cos(turn), r * std::sin(turn)}};
    };
    const double turn = 360 * kDegree * random.Unit();
    points = {{{0, 0, 0}}, {{1, 0, 0}}, third(turn), third(turn + angle * kDegree)};
    f = Triangle(points, 0, 1, 2, 10);
    g = Triangle(points, 1, 3, 0, 11);
  }
  Point3 InF(test::Random& random) const { return PlaceIn(points, 1, 2, random); }
  Point3 InG(test::Random& random) const { return PlaceIn(points, 1, 3, random); }

  std::vector<Point3> points;
  Facet f, g;
};

TEST(SharpFacets, ATurnedPlaceIsAsFarFromBothEndsAndTurnsBack) {
  constexpr std::uint64_t kSeed = 5;
  test::Random random(kSeed);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(i));
    const Wedge w(1 + 68 * random.Unit(), random);
    const Point3 p = w.InF(random);
    const auto x = TurnedInto(w.g, w.f, p);
    if (!x) continue;
    ++found;
    EXPECT_EQ(x->axis, (Axis{0, 1}));
    EXPECT_TRUE(w.g.IsInside(x->p));
    for (const int end : {0, 1}) {
      EXPECT_NEAR(SquaredDistance(x->p, w.points[end]), SquaredDistance(p, w.points[end]), 1e-13);
    }
    // Every place of g is nearer to x than to p.
    for (int k = 0; k < 10; ++k) {
      const Point3 y = w.InG(random);
      EXPECT_LE(SquaredDistance(y, x->p), SquaredDistance(y, p) + 1e-13);
    }
    const auto back = TurnedInto(w.f, w.g, x->p);
    ASSERT_TRUE(back);
    EXPECT_NEAR(SquaredDistance(back->p, p), 0, 1e-26);
  }
  EXPECT_GT(found, 1000);
}

// Indices of vertices depend on former edits; places must not.
TEST(SharpFacets, PlacesDoNotDependOnTheIndicesOfCorners) {
  constexpr std::uint64_t kSeed = 11;
  test::Random random(kSeed);
  constexpr VertexIndex kOthers[] = {3, 2, 1, 0};  // of the corners in another mesh
  int found = 0;
  for (int i = 0; i < 500; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(i));
    Wedge w(1 + 68 * random.Unit(), random);
    for (Point3& p : w.points) {
      for (double& x : p.c) x += 1.0 / 3;  // nothing is exact
    }
    std::vector<Point3> moved(4);
    for (std::size_t v = 0; v < 4; ++v) moved[kOthers[v]] = w.points[v];
    const auto facets = [](const std::vector<Point3>& points, auto at) {
      return std::pair(Triangle(points, at(0), at(1), at(2), 10),
                       Triangle(points, at(1), at(3), at(0), 11));
    };
    const auto [f, g] = facets(w.points, [](VertexIndex v) { return v; });
    const auto [f2, g2] = facets(moved, [&](VertexIndex v) { return kOthers[v]; });
    const Point3 p = f.plane().Foot(geometry::Midpoint(w.points[0], w.points[2]));
    const Point3 x = geometry::Midpoint(p, w.points[1]);
    const auto turned = TurnedInto(g, f, x), turned2 = TurnedInto(g2, f2, x);
    ASSERT_EQ(turned.has_value(), turned2.has_value());
    const auto on = OnLattice(f, {0, 1}, x, 0.1), on2 = OnLattice(f2, {3, 2}, x, 0.1);
    ASSERT_EQ(on.has_value(), on2.has_value());
    if (!turned || !on) continue;
    ++found;
    EXPECT_EQ(turned->p, turned2->p);
    EXPECT_EQ(on->p, on2->p);
  }
  EXPECT_GT(found, 200);
}

// Two facets have the same lattice: one point's counterpart is the other.
TEST(SharpFacets, TheLatticeAboutAnEdgeIsNearNestedAndCommon) {
  constexpr std::uint64_t kSeed = 8;
  test::Random random(kSeed);
  int found = 0, turned = 0;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(i));
    const Wedge w(1 + 68 * random.Unit(), random);
    const Point3 p = w.InF(random);
    const double step = std::exp2(-7 * random.Unit());
    const auto x = OnLattice(w.f, {0, 1}, p, step);
    if (!x) continue;
    ++found;
    EXPECT_TRUE(w.f.IsInside(x->p));
    EXPECT_LE(std::sqrt(SquaredDistance(x->p, p)), kFarthestOnLattice * step * (1 + 1e-12));
    EXPECT_TRUE(((x->at.i | x->at.j) & 1) != 0);
    EXPECT_GT(x->at.j, 0);
    // It stays where it is, in this lattice and in finer ones, from either end of the edge.
    for (const double finer : {1., .5, .125}) {
      const auto again = OnLattice(w.f, {1, 0}, x->p, finer * step);
      ASSERT_TRUE(again);
      EXPECT_EQ(again->at, x->at);
      EXPECT_EQ(again->p, x->p);
    }
    const auto other = TurnedInto(w.g, w.f, x->p);
    if (!other) continue;
    const auto same = OnLattice(w.g, {0, 1}, other->p, step);
    ASSERT_TRUE(same);
    ++turned;
    EXPECT_EQ(same->at, x->at);
    EXPECT_NEAR(SquaredDistance(same->p, other->p), 0, 1e-28);
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(turned, 500);
}

TEST(SharpFacets, FacetsAtSeventyDegreesOrMoreHaveNoTurnedPlaces) {
  test::Random random(6);
  for (int i = 0; i < 500; ++i) {
    const Wedge w(70 + 220 * random.Unit(), random);
    EXPECT_FALSE(TurnedInto(w.g, w.f, w.InF(random)));
  }
}

// A segment from the corner 0 that rises over the triangle.
TEST(SharpFacets, AMovedPlaceIsAsFarFromTheCorner) {
  constexpr std::uint64_t kSeed = 7;
  test::Random random(kSeed);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(i));
    const double wide = (20 + 90 * random.Unit()) * kDegree, at = wide * random.Unit();
    const double up = 89 * random.Unit() * kDegree;
    const std::vector<Point3> points = {
        {{0, 0, 0}}, {{1, 0, 0}}, {{std::cos(wide), std::sin(wide), 0}}};
    const Facet f = Triangle(points, 0, 1, 2, 10);
    const Point3 end = {{std::cos(up) * std::cos(at), std::cos(up) * std::sin(at), std::sin(up)}};
    const double share = 0.5 * random.Unit();
    OwnedVertex v;
    for (int k = 0; k < 3; ++k) v.p[k] = share * end[k];
    v.ends = {0, 7};
    v.positions = {points[0], end};
    const Point3 foot = {{v.p[0], v.p[1], 0}};
    const auto x = MovedInto(f, v, foot);
    // By angle: is some direction in the triangle nearer to the segment than both edges are?
    bool leans = false;
    for (int k = 1; k < 1000; ++k) {
      const double d = wide * k / 1000;
      const double to_u = std::cos(up) * std::cos(d - at);
      leans = leans || (to_u > std::cos(d) + 1e-9 && to_u > std::cos(wide - d) + 1e-9);
    }
    if (up > 70.001 * kDegree) leans = false;
    if (std::fabs(up - 70 * kDegree) < 0.001 * kDegree) continue;
    if (leans) {
      ASSERT_TRUE(x);
    }
    if (!x) continue;
    ++found;
    EXPECT_LT(up, 70.001 * kDegree);
    EXPECT_EQ(x->axis, (Axis{0, 0}));
    EXPECT_NEAR(std::sqrt(SquaredDistance(x->p, points[0])), share, 1e-15);
    EXPECT_NEAR(x->p[0] * v.p[1] - x->p[1] * v.p[0], 0, 1e-15);
  }
  EXPECT_GT(found, 500);
}

double DistanceFrom0(const Point3& p) { return std::sqrt(SquaredDistance(p, {{0, 0, 0}})); }
// In spherical coordinates.
Point3 Towards(double at, double up) {
  return {{std::cos(up) * std::cos(at), std::cos(up) * std::sin(at), std::sin(up)}};
}
// A vertex on the segment from the corner 0 in that direction, on a shell about the corner.
OwnedVertex OnShell(const Point3& direction, double distance) {
  OwnedVertex v;
  for (int k = 0; k < 3; ++k) v.p[k] = distance * direction[k];
  v.origin = v.p;
  v.ends = {0, 7};
  v.positions = {Point3{{0, 0, 0}}, direction};
  v.apex = 0;
  return v;
}
OwnedVertex CounterpartOf(const OwnedVertex& v, const Facet& facet, const Point3& p) {
  OwnedVertex x;
  x.p = p;
  x.origin = v.origin;
  x.facet = &facet;
  x.apex = v.apex;
  x.is_counterpart = true;
  return x;
}

// Two vertices of a segment on shells about its end, and their counterparts, are no trapezoid.
// Nevertheless each place of the facet is nearer to the counterpart than to the vertex. The
// counterpart's own, in the vertex's direction, is the vertex: the facet `over` has the segment
// inside.
TEST(SharpFacets, ACounterpartIsBesideTheShellAndItsOwnIsTheVertex) {
  constexpr std::uint64_t kSeed = 8;
  test::Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(i));
    const double at = (20 + 50 * random.Unit()) * kDegree;
    const double up = std::pow(10, -4 * random.Unit());
    const Point3 end = Towards(at, up), left = Towards(at + 0.1, up + 0.1);
    const std::vector<Point3> points = {
        {{0, 0, 0}},
        {{1, 0, 0}},
        {{0, 1, 0}},
        left,
        {{2 * end[0] - left[0], 2 * end[1] - left[1], 2 * end[2] - left[2]}}};
    const Facet f = Triangle(points, 0, 1, 2, 10), over = Triangle(points, 0, 3, 4, 11);
    std::array<double, 2> parts = {0.5, 0.25};
    for (double& part : parts) {
      const OwnedVertex v = OnShell(end, part * (1 + 0x1p-25 * random.Unit()));
      const auto x = MovedInto(f, v, {{v.p[0], v.p[1], 0}});
      ASSERT_TRUE(x);
      const auto back = MovedInto(over, CounterpartOf(v, f, x->p), v.p);
      ASSERT_TRUE(back);
      EXPECT_NEAR(std::sqrt(SquaredDistance(back->p, v.p)), 0, 1e-15);
      const Point3 place = PlaceIn(points, 1, 2, random);
      EXPECT_LT(SquaredDistance(place, x->p), SquaredDistance(place, v.p));
      part = 1 - DistanceFrom0(x->p) / DistanceFrom0(v.p);
    }
    const double most = std::sin(up) * std::sin(up) / 127;
    EXPECT_LE(parts[0], std::min(0x1.001p-20, most + 1e-14));
    EXPECT_GE(parts[0], std::min(0x0.2fp-20, 0.75 * most - 1e-14));
    EXPECT_NEAR(parts[0], parts[1], 1e-14);
  }
}

// A segment above two facets that are much nearer to each other: each place of the one is nearer to
// the counterpart of a counterpart on the other than to that, and the next is the first again.
TEST(SharpFacets, CounterpartsOfOneVertexAreOnOneShellOrFarFromEachOther) {
  constexpr std::uint64_t kSeed = 9;
  test::Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(i));
    const double at = (20 + 50 * random.Unit()) * kDegree;
    const double up = std::pow(10, -0.5 - 3.5 * random.Unit());
    const double between = up * std::pow(10, -0.5 - 3 * random.Unit());
    const std::vector<Point3> points = {
        {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, Towards(0, between), Towards(90 * kDegree, between)};
    const Facet f = Triangle(points, 0, 1, 2, 10), g = Triangle(points, 0, 3, 4, 11);
    const OwnedVertex v = OnShell(Towards(at, up), 0.5);
    const auto on_f = MovedInto(f, v, f.plane().Foot(v.p));
    ASSERT_TRUE(on_f);
    const auto on_g = MovedInto(g, CounterpartOf(v, f, on_f->p), g.plane().Foot(on_f->p));
    ASSERT_TRUE(on_g);
    const double angle = std::sqrt(SquaredDistance(on_f->p, on_g->p)) / 0.5;
    EXPECT_LE(std::fabs(DistanceFrom0(on_f->p) / DistanceFrom0(on_g->p) - 1),
              angle * angle / 30 + 1e-15);
    const auto back = MovedInto(f, CounterpartOf(v, g, on_g->p), on_f->p);
    ASSERT_TRUE(back);
    EXPECT_NEAR(std::sqrt(SquaredDistance(back->p, on_f->p)), 0, 1e-15);
  }
}

TEST(SharpFacets, AnEdgeInTheFacetsOwnDirectionDoesNotLean) {
  const std::vector<Point3> points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
  const Facet f = Triangle(points, 0, 1, 2, 10);
  EXPECT_TRUE(LeansOver(
      {std::cos(0.5) * std::sqrt(.5), std::cos(0.5) * std::sqrt(.5), std::sin(0.5)}, f, 0));
  EXPECT_FALSE(LeansOver({0, 0, 1}, f, 0));
  EXPECT_FALSE(LeansOver({-std::sqrt(.5), -std::sqrt(.5), 0}, f, 0));
  EXPECT_FALSE(LeansOver({std::cos(0.3), -std::sin(0.3), 0}, f, 0));
}

}  // namespace
}  // namespace dynmesh::meshing::sharp_facets_test
