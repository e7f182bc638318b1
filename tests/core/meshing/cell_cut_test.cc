// The intersection of a Voronoi cell and a facet, against points of the facet and the vertex
// nearest to each.
#include "core/meshing/cell_cut.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/constructions.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::cell_cut_test {
namespace {

using geometry::Point3;

constexpr std::uint64_t kSeed = 4711;

// A square of side 8 in a random plane through the middle of the unit cube.
Facet RandomFacet(test::Random& random, std::array<geometry::Vector3, 2>* axes) {
  const geometry::Vector3 n = {random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5};
  geometry::Vector3 u = geometry::Cross(n, {0.3, 0.5, 0.7}), v = geometry::Cross(n, u);
  for (geometry::Vector3* x : {&u, &v}) {
    const double length = std::sqrt(geometry::Dot(*x, *x));
    for (double& c : *x) c /= length;
  }
  *axes = {u, v};
  const auto corner = [&](VertexIndex i) {
    const double a = i == 0 || i == 3 ? -4 : 4, b = i < 2 ? -4 : 4;
    Point3 p;
    for (int k = 0; k < 3; ++k) p[k] = 0.5 + a * u[k] + b * v[k];
    return p;
  };
  return Facet(std::vector<std::vector<VertexIndex>>{{0, 1, 2, 3}}, 1, corner);
}

TEST(CellCut, IsTheNearestOfThePlacesThatAreNearestToTheVertex) {
  test::Random random(kSeed);
  int cut_count = 0, none_count = 0;
  for (int round = 0; round < 300; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(round));
    std::vector<Point3> points(30);
    for (Point3& p : points) p = {{random.Unit(), random.Unit(), random.Unit()}};
    std::array<geometry::Vector3, 2> axes;
    const Facet facet = RandomFacet(random, &axes);
    SpaceStar star;
    star.Begin(0, points[0], 2);
    for (std::uint32_t i = 1; i < points.size(); ++i) star.Insert(i, points[i]);
    CellCut cut;
    cut.Begin(star);
    const auto found = cut.Of(facet);
    // The oracle: a grid of points about the foot.
    const Point3 foot = facet.plane().Foot(points[0]);
    double nearest = INFINITY;
    constexpr double kStep = 0.02;
    for (double a = -1.5; a <= 1.5; a += kStep) {
      for (double b = -1.5; b <= 1.5; b += kStep) {
        Point3 x;
        for (int k = 0; k < 3; ++k) x[k] = foot[k] + a * axes[0][k] + b * axes[1][k];
        const double d2 = geometry::SquaredDistance(x, points[0]);
        bool ours = d2 < nearest;
        for (std::size_t i = 1; ours && i < points.size(); ++i) {
          ours = d2 <= geometry::SquaredDistance(x, points[i]);
        }
        if (ours) nearest = d2;
      }
    }
    if (nearest < INFINITY) {
      ASSERT_TRUE(found.has_value());
      EXPECT_LE(found->distance2, nearest * (1 + 1e-9));
      // Not much nearer than what the grid has, unless the cut is thinner than that.
      EXPECT_FALSE(found->touches);
    }
    if (found && !found->touches) {
      EXPECT_NEAR(facet.plane().Height(found->nearest), 0, 1e-14);
      for (std::size_t i = 1; i < points.size(); ++i) {
        EXPECT_LE(found->distance2,
                  geometry::SquaredDistance(found->nearest, points[i]) * (1 + 1e-8));
      }
    }
    ++(found ? cut_count : none_count);
  }
  EXPECT_GT(cut_count, 30);
  EXPECT_GT(none_count, 30);
}

TEST(CellCut, TouchesWhereTheFarSideIsEquallyNear) {
  // The facet's corners and two poles are equally far from its middle.
  const std::vector<Point3> corners = {{{1, 0, 0}}, {{0, 1, 0}}, {{-1, 0, 0}}, {{0, -1, 0}}};
  const Facet facet(std::vector<std::vector<VertexIndex>>{{0, 1, 2, 3}}, 1,
                    [&](VertexIndex v) { return corners[v]; });
  for (const double height : {1.0, 0.9, 1.1}) {
    SpaceStar star;
    star.Begin(4, {{0, 0, height}}, 8);
    for (VertexIndex v = 0; v < 4; ++v) star.Insert(v, corners[v]);
    star.Insert(5, {{0, 0, -1.5}});
    CellCut cut;
    cut.Begin(star);
    const auto found = cut.Of(facet);
    EXPECT_EQ(found.has_value(), height <= 1) << height;
    if (found) {
      EXPECT_EQ(found->touches, height == 1) << height;
      EXPECT_NEAR(found->distance2, height * height, 1e-9);
    }
  }
}

TEST(CellCut, AnEdgeGoesThroughAFacetOrPastIt) {
  const std::vector<Point3> corners = {{{1, 0, 0}}, {{0, 1, 0}}, {{-1, 0, 0}}, {{0, -1, 0}}};
  const Facet facet(std::vector<std::vector<VertexIndex>>{{0, 1, 2, 3}}, 1,
                    [&](VertexIndex v) { return corners[v]; });
  for (const double x : {0.0, 0.4, 2.5}) {
    SpaceStar star;
    star.Begin(4, {{x, 0, 1}}, 8);
    star.Insert(5, {{x, 0.1, -1}});
    star.Insert(6, {{x, 0.1, 2}});
    for (int i = 0; i < star.slot_count(); ++i) {
      if (!SpaceStar::IsUsed(star[i]) || SpaceStar::IsGhost(star[i].id)) continue;
      EXPECT_EQ(CellCut::GoesThrough(star.position(), star[i], facet), star[i].id == 5 && x < 1)
          << x;
    }
  }
}

// Of vertices and facets of a lattice, where cells touch facets; of others, where they do not.
TEST(CellCut, NoFacetThatMeetsTheCellIsLeftOut) {
  test::Random random(kSeed);
  int met = 0, touched = 0, left_out = 0;
  for (int round = 0; round < 3000; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(round));
    const bool is_lattice = round % 2 == 0;
    const double scale = round % 3 == 0 ? 1e-3 : 1, from = round % 5 == 0 ? 100 : 0;
    const auto place = [&] {
      Point3 p;
      for (int k = 0; k < 3; ++k) {
        const double at = is_lattice ? std::floor(4 * random.Unit()) : 4 * random.Unit();
        p[k] = from + scale * at;
      }
      return p;
    };
    SpaceStar star;
    star.Begin(0, place(), 16 * scale);
    for (std::uint32_t i = 1; i < 40; ++i) {
      const Point3 p = place();
      if (p != star.position()) star.Insert(i, p);
    }
    CellCut cut;
    cut.Begin(star);
    for (int k = 0; k < 8; ++k) {
      // A triangle, a quadrangle that may be notched, a square with a hole, or one of many corners.
      const Point3 a = place(), b = place(), c = place();
      const auto in_plane = [&](double s, double t) {
        Point3 p;
        for (int i = 0; i < 3; ++i) p[i] = a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]);
        return p;
      };
      std::vector<Point3> corners = {a, b, c};
      std::vector<std::vector<VertexIndex>> rings = {{0, 1, 2}};
      const geometry::Vector3 n =
          geometry::Cross(geometry::Difference(b.c, a.c), geometry::Difference(c.c, a.c));
      if (!(geometry::Dot(n, n) > 1e-6 * scale * scale * scale * scale)) continue;
      if (k % 4 == 1) {
        corners.push_back(in_plane(0.25, 0.25));
        rings = {{0, 1, 3, 2}};
      } else if (k % 4 == 2) {
        corners = {a, b, in_plane(1, 1), c};
        for (const auto& [s, t] : {std::pair(0.25, 0.25), {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}})
          corners.push_back(in_plane(s, t));
        rings = {{0, 1, 2, 3}, {4, 5, 6, 7}};
      } else if (k % 4 == 3) {
        corners.clear();
        rings = {{}};
        for (VertexIndex i = 0; i < 12; ++i) {
          corners.push_back(
              in_plane(std::cos(i * 0.5235987755982988), std::sin(i * 0.5235987755982988)));
          rings[0].push_back(i);
        }
      }
      const Facet facet(rings, 1, [&](VertexIndex v) { return corners[v]; });
      const auto naive = cut.NaiveOf(facet);
      const bool may_meet = cut.MayMeet(facet);
      ASSERT_TRUE(may_meet || !naive) << k;
      const auto found = cut.Of(facet);
      ASSERT_EQ(found.has_value(), naive.has_value());
      if (found) {
        EXPECT_EQ(found->nearest, naive->nearest);
        EXPECT_EQ(found->distance2, naive->distance2);
        EXPECT_EQ(found->touches, naive->touches);
      }
      met += naive && !naive->touches ? 1 : 0;
      touched += naive && naive->touches ? 1 : 0;
      left_out += may_meet ? 0 : 1;
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_GT(touched, 30);
  EXPECT_GT(left_out, 5000);
}

}  // namespace
}  // namespace dynmesh::meshing::cell_cut_test
