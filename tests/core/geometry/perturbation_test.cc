// Does InCircle come from one perturbed lifting? Then brute force over all triples of a
// set finds exactly one triangulation of it, however its points are listed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "core/geometry/predicates.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::geometry::perturbation_test {
namespace {

using Triangle = std::array<Point2, 3>;

// All counter-clockwise triples, least corner first, with nothing inside their circle.
std::set<Triangle> BruteForceDelaunay(const std::vector<Point2>& points) {
  std::set<Triangle> result;
  for (const Point2& a : points) {
    for (const Point2& b : points) {
      for (const Point2& c : points) {
        if (!(a < b && a < c) || Orientation(a, b, c) <= 0) continue;
        const bool empty = std::all_of(points.begin(), points.end(), [&](const Point2& d) {
          return d == a || d == b || d == c || !InCircle(a, b, c, d);
        });
        if (empty) result.insert({a, b, c});
      }
    }
  }
  return result;
}

// Twice the area of the hull and the number of points on its boundary (collinear ones
// included), by a monotone chain that keeps collinear points.
int PointsOnHull(const std::vector<Point2>& points) {
  int count = 0;
  for (const Point2& p : points) {
    bool on_hull = false;
    for (const Point2& q : points) {
      if (q == p) continue;
      on_hull |= std::all_of(points.begin(), points.end(),
                             [&](const Point2& r) { return Orientation(p, q, r) >= 0; });
    }
    count += on_hull;
  }
  return count;
}

bool AllCollinear(const std::vector<Point2>& points) {
  for (std::size_t i = 2; i < points.size(); ++i) {
    if (Orientation(points[0], points[1], points[i]) != 0) return false;
  }
  return true;
}

void ExpectOneTriangulation(const std::vector<Point2>& points) {
  const auto triangles = BruteForceDelaunay(points);
  // Euler: n points, h of them on the hull, make 2n - 2 - h triangles.
  ASSERT_EQ(triangles.size(), 2 * points.size() - 2 - PointsOnHull(points));
  std::map<std::pair<Point2, Point2>, int> edges;
  for (const Triangle& t : triangles) {
    for (int i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  // No directed edge twice: nothing overlaps. Edges without a twin: the hull.
  int hull = 0;
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    hull += !edges.contains({edge.second, edge.first});
  }
  ASSERT_EQ(hull, PointsOnHull(points));
}

std::vector<Point2> DistinctPoints(testing::Kind kind, std::uint64_t seed, int count) {
  testing::PointSource<2> source(kind, seed);
  std::set<Point2> points;
  for (int i = 0; i < count; ++i) points.insert(source.Next());
  return {points.begin(), points.end()};
}

TEST(Perturbation, MakesDelaunayUniqueOnDegenerateSets) {
  const std::uint64_t seed = testing::NewSeed();
  for (const testing::Kind kind : testing::kAllKinds) {
    for (std::uint64_t round = 0; round < 60; ++round) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " kind " +
                   std::to_string(static_cast<int>(kind)) + " round " + std::to_string(round));
      auto points = DistinctPoints(kind, seed + round, 4 + static_cast<int>(round % 15));
      if (points.size() < 3 || AllCollinear(points)) continue;
      ExpectOneTriangulation(points);
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(Perturbation, MakesDelaunayUniqueOnAWholeGrid) {
  std::vector<Point2> points;
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 5; ++y) points.push_back({{x * 0.5, y * 0.5}});
  }
  ExpectOneTriangulation(points);
}

TEST(Perturbation, DoesNotDependOnTheOrderOfTheList) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (std::uint64_t round = 0; round < 20; ++round) {
    auto points = DistinctPoints(testing::Kind::kGrid, seed + round, 14);
    const auto expected = BruteForceDelaunay(points);
    std::shuffle(points.begin(), points.end(), random);
    ASSERT_EQ(BruteForceDelaunay(points), expected);
  }
}

// The reason that it is canonical: answers about four points do not depend on the set.
TEST(Perturbation, TrianglesOfASubsetSurviveUnlessANewPointKillsThem) {
  const std::uint64_t seed = testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (std::uint64_t round = 0; round < 20; ++round) {
    auto points = DistinctPoints(testing::Kind::kCocircular, seed + round, 12);
    const Point2 last = points[round % points.size()];
    const auto with = BruteForceDelaunay(points);
    std::erase(points, last);
    for (const Triangle& t : BruteForceDelaunay(points)) {
      ASSERT_EQ(with.contains(t), !InCircle(t[0], t[1], t[2], last));
    }
  }
}

}  // namespace
}  // namespace dynmesh::geometry::perturbation_test
