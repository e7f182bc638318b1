// The star of a vertex against the whole triangulation of the same points, and the four
// ghosts, by CGAL (which breaks ties by coordinates too).
#include "core/meshing/planar_star.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/delaunay/delaunay_oracle.h"

namespace dynmesh::meshing::planar_star_test {
namespace {

using delaunay::testing::Layout;
using geometry::Point2;

// Begins with the least, so that two rings can be compared.
std::vector<Point2> Turned(std::vector<Point2> ring) {
  std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
  return ring;
}

std::vector<Point2> RingOf(const PlanarStar& star) {
  std::vector<Point2> ring;
  for (int i = 0; i < star.size(); ++i) ring.push_back(star[i].p);
  return Turned(ring);
}

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangulation = CGAL::Delaunay_triangulation_2<Kernel>;

// v's neighbours, counter-clockwise; empty if v is on the hull.
std::vector<Point2> RingByCgal(const std::vector<Point2>& others, const Point2& v) {
  Triangulation dt;
  std::vector<Kernel::Point_2> list;
  for (const Point2& p : others) list.emplace_back(p[0], p[1]);
  dt.insert(list.begin(), list.end());
  const auto handle = dt.insert(Kernel::Point_2(v[0], v[1]));
  std::vector<Point2> ring;
  auto u = dt.incident_vertices(handle);
  const auto first = u;
  do {
    if (dt.is_infinite(u)) return {};
    ring.push_back({{u->point().x(), u->point().y()}});
  } while (++u != first);
  return Turned(ring);
}

std::vector<Point2> WithGhosts(std::vector<Point2> points, const Point2& v, double reach) {
  for (int k = 0; k < 4; ++k) points.push_back(PlanarStar::Ghost(v, reach, k));
  return points;
}

// Of half-widths from the least distance to far beyond the box. Not so that a ghost
// lies on a point.
double RandomReach(const std::vector<Point2>& points, const Point2& v, std::mt19937_64& random) {
  double least2 = INFINITY;
  for (const Point2& p : points) {
    if (p != v) least2 = std::min(least2, geometry::SquaredDistance(p, v));
  }
  const int steps = static_cast<int>(std::log2(16 / std::sqrt(least2))) + 1;
  const double drawn = std::sqrt(least2) * 0.37 * std::exp2(static_cast<double>(random() % steps));
  const double reach = std::max(drawn, 0x1p-44);  // refinement looks no nearer
  for (int k = 0; k < 4; ++k) {
    const Point2 ghost = PlanarStar::Ghost(v, reach, k);
    if (std::find(points.begin(), points.end(), ghost) != points.end()) return reach * 1.01;
  }
  return reach;
}

class StarTest : public testing::TestWithParam<Layout> {};

TEST_P(StarTest, IsThatOfTheTriangulationOfPointsAndGhosts) {
  int with_ghosts = 0, without = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::vector<Point2> points =
        delaunay::testing::DistinctPoints(GetParam(), seed, 4 + static_cast<int>(random() % 120));
    PlanarStar star;
    for (int k = 0; k < 12; ++k) {
      std::shuffle(points.begin(), points.end(), random);
      const PlanarStar::Id v = static_cast<PlanarStar::Id>(random() % points.size());
      const double reach = RandomReach(points, points[v], random);
      star.Begin(v, points[v], reach);
      for (PlanarStar::Id u = 0; u < points.size(); ++u) {
        if (u == v) continue;
        const int size = star.size();
        bool conflicts = false;
        for (int i = 0; i < size; ++i) conflicts = conflicts || star.Conflicts(i, points[u]);
        ASSERT_EQ(star.Insert(u, points[u]), conflicts);
        ASSERT_EQ(star.Has(u), conflicts);
      }
      ASSERT_EQ(RingOf(star), RingByCgal(WithGhosts(points, points[v], reach), points[v]))
          << "vertex " << points[v][0] << " " << points[v][1] << " reach " << reach;
      int ghosts = 0;
      for (int i = 0; i < star.size(); ++i) {
        if (PlanarStar::IsGhost(star[i].id)) {
          ++ghosts;
        } else {
          ASSERT_EQ(star[i].p, points[star[i].id]);
        }
      }
      ++(ghosts > 0 ? with_ghosts : without);
    }
  }
  EXPECT_GT(with_ghosts, 50);
  EXPECT_GT(without, 0);
}

// Points outside of the square of half-width H do not affect a Voronoi vertex inside it: the star
// with ghosts and the one without have the same Voronoi vertices there.
TEST_P(StarTest, CornersWithinReachAreThoseOfTheTriangulationWithoutGhosts) {
  int within = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const std::vector<Point2> points = delaunay::testing::DistinctPoints(GetParam(), seed, 80);
    PlanarStar star;
    for (PlanarStar::Id v = 0; v < points.size(); ++v) {
      const std::vector<Point2> ring = RingByCgal(points, points[v]);
      if (ring.empty()) continue;
      const double reach = RandomReach(points, points[v], random);
      if (reach < 0x1p-40) continue;  // so near, the places of the ghosts are rounded
      star.Begin(v, points[v], reach);
      for (PlanarStar::Id u = 0; u < points.size(); ++u) {
        if (u != v) star.Insert(u, points[u]);
      }
      for (int i = 0; i < star.size(); ++i) {
        const PlanarStar::Neighbour& n = star[i];
        if (!(std::fabs(n.w[0]) + n.error < 0.999 * reach &&
              std::fabs(n.w[1]) + n.error < 0.999 * reach)) {
          continue;
        }
        ++within;
        const auto at = std::find(ring.begin(), ring.end(), n.p);
        ASSERT_NE(at, ring.end());
        ASSERT_EQ(star[star.Next(i)].p, at + 1 == ring.end() ? ring.front() : *(at + 1));
      }
    }
  }
  EXPECT_GT(within, 500);
}

// A ring given at once equals the star with ghosts after these are inserted; within reach, it
// equals it already.
TEST_P(StarTest, OfARingGivenAtOnceIsTheSame) {
  int within = 0, beyond = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const std::vector<Point2> points = delaunay::testing::DistinctPoints(GetParam(), seed, 80);
    std::map<Point2, PlanarStar::Id> id_at;
    for (PlanarStar::Id u = 0; u < points.size(); ++u) id_at[points[u]] = u;
    PlanarStar star;
    for (PlanarStar::Id v = 0; v < points.size(); ++v) {
      const std::vector<Point2> ring = RingByCgal(points, points[v]);
      if (ring.empty()) continue;
      const double reach = RandomReach(points, points[v], random);
      const std::vector<Point2> wanted =
          RingByCgal(WithGhosts(points, points[v], reach), points[v]);
      star.BeginRing(v, points[v], reach);
      for (const Point2& p : ring) star.Append(id_at.at(p), p);
      if (star.Close() && star.IsWithinReach()) {
        ++within;
        ASSERT_EQ(ring, wanted);
      } else {
        ++beyond;
      }
      star.InsertGhosts();
      ASSERT_EQ(RingOf(star), wanted);
    }
  }
  EXPECT_GT(within, 10);
  EXPECT_GT(beyond, 0);
}

// As defined at PlanarStar::SectorOf, one sector at a time.
int PlainSectorOf(const std::vector<Point2>& directions, double x, double y) {
  const int count = static_cast<int>(directions.size());
  const auto side = [&](int i) {
    const Point2& d = directions[static_cast<std::size_t>(i % count)];
    const double left = d[0] * y, right = d[1] * x;
    const bool is_sure = std::fabs(left - right) > 1e-15 * (std::fabs(left) + std::fabs(right));
    return is_sure ? left - right : 0;
  };
  for (int i = 0; i < count; ++i) {
    if (side(i) == 0) return -1;
    if (side(i) > 0 && side(i + 1) < 0) return i;
  }
  return -1;
}

// Rings of any size, points in the directions of members and opposite to them among others.
TEST(PlanarStar, TheSectorOfAPointIsTheFirstThatCertainlyHoldsIt) {
  int found = 0, unsure = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    const std::size_t count = random() % 5 == 0 ? 3 + random() % 300 : 3 + random() % 12;
    std::vector<double> angles;
    for (std::size_t i = 0; i < count; ++i) angles.push_back(6.283185307179586 * unit());
    std::sort(angles.begin(), angles.end());
    std::vector<Point2> ring;
    for (const double angle : angles) {
      const double length = std::exp2(20 * unit() - 10);
      ring.push_back({{length * std::cos(angle), length * std::sin(angle)}});
    }
    for (int k = 0; k < 20; ++k) {
      Point2 at = {{unit() - 0.5, unit() - 0.5}};
      if (k >= 14) {
        at = ring[random() % count];
        const double scale = k % 2 == 0 ? 0.75 : -3;
        for (double& x : at.c) x *= scale;
      }
      if (k == 13) at = {{0, 0}};
      const int sector = PlanarStar::SectorOf(
          static_cast<int>(count),
          [&](int i) {
            const Point2& d = ring[static_cast<std::size_t>(i)];
            return std::pair(d[0], d[1]);
          },
          at[0], at[1]);
      ASSERT_EQ(sector, PlainSectorOf(ring, at[0], at[1])) << "of " << count;
      ++(sector < 0 ? unsure : found);
    }
  }
  EXPECT_GT(found, 10000);
  EXPECT_GT(unsure, 1000);
}

INSTANTIATE_TEST_SUITE_P(All, StarTest, testing::ValuesIn(delaunay::testing::kAllLayouts),
                         [](const auto& its) { return delaunay::testing::LayoutName(its.param); });

}  // namespace
}  // namespace dynmesh::meshing::planar_star_test
