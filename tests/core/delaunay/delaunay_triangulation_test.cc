// DelaunayTriangulation piece by piece: batch insertion, location, walks, conflict tests, removals
// of large degree, and that the checker finds errors.
#include "core/delaunay/delaunay_triangulation.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/delaunay/delaunay_insert_order.h"
#include "tests/core/delaunay/delaunay_oracle.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay::delaunay_triangulation_test {
namespace {

using namespace testing;
using geometry::testing::NewSeed;
constexpr VertexIndex kInfinite = DelaunayTriangulation::kInfinite;

std::vector<VertexIndex> IndicesFrom4(std::size_t count) {
  std::vector<VertexIndex> indices(count);
  std::iota(indices.begin(), indices.end(), VertexIndex{4});
  return indices;
}

DelaunayTriangulation Triangulate(const std::vector<Point2>& points) {
  DelaunayTriangulation dt = EmptyBox();
  dt.InsertAll(IndicesFrom4(points.size()), points);
  return dt;
}

void ExpectIsDelaunayOf(const DelaunayTriangulation& dt, std::vector<Point2> points) {
  std::string why;
  ASSERT_TRUE(dt.Check(&why)) << why;
  for (const Point2& p : Corners()) points.push_back(p);
  ASSERT_EQ(TrianglesOf(dt), CgalDelaunay(points));
}

TEST(DelaunayTriangulation, OfABareBoxCutsOffTheGreatestCorner) {
  const DelaunayTriangulation dt = EmptyBox();
  EXPECT_EQ(dt.vertex_count(), 4u);
  EXPECT_EQ(dt.simplex_count(), 2u);
  ExpectIsDelaunayOf(dt, {});
}

TEST(DelaunayTriangulation, ResetStartsOver) {
  DelaunayTriangulation dt = Triangulate(DistinctPoints(Layout::kUniform, 1, 100));
  dt.Reset(kLow, kHigh, {7, 5, 6, 2});
  EXPECT_EQ(dt.vertex_count(), 4u);
  EXPECT_FALSE(dt.Contains(4));
  EXPECT_TRUE(dt.Contains(7));
  EXPECT_EQ(dt.position(6), kHigh);
  ExpectIsDelaunayOf(dt, {});
}

TEST(DelaunayTriangulation, InsertAllAgreesWithCgalOnEveryLayout) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const Layout layout : kAllLayouts) {
    SCOPED_TRACE(LayoutName(layout));
    const auto points = DistinctPoints(layout, seed, 5000);
    ASSERT_NO_FATAL_FAILURE(ExpectIsDelaunayOf(Triangulate(points), points));
  }
}

TEST(DelaunayTriangulation, InsertAllContinuesWhereOthersBegan) {
  const auto points = DistinctPoints(Layout::kGrid, 3, 900);
  const std::size_t half = points.size() / 2;
  const auto indices = IndicesFrom4(points.size());
  DelaunayTriangulation dt = EmptyBox();
  dt.InsertAll({indices.data(), half}, {points.data(), half});
  dt.InsertAll({indices.data() + half, points.size() - half},
               {points.data() + half, points.size() - half});
  dt.InsertAll({}, {});
  EXPECT_TRUE(dt.created().empty());
  EXPECT_TRUE(dt.deleted().empty());
  ExpectIsDelaunayOf(dt, points);
}

TEST(DelaunayTriangulation, WorksInATinyBoxFarFromTheOrigin) {
  const Point2 lo{{1e6, -1e6}}, hi{{1e6 + 0x1p-20, -1e6 + 0x1p-20}};
  DelaunayTriangulation dt;
  dt.Reset(lo, hi, {0, 1, 2, 3});
  VertexIndex v = 4;
  for (int x = 0; x < 9; ++x) {
    for (int y = 0; y < 9; ++y) {
      const Point2 p{{lo[0] + x * 0x1p-23, lo[1] + y * 0x1p-23}};
      if (x % 8 != 0 || y % 8 != 0) dt.Insert(v++, p, 0);
    }
  }
  std::string why;
  ASSERT_TRUE(dt.Check(&why)) << why;
  EXPECT_EQ(dt.vertex_count(), 81u);
  EXPECT_EQ(dt.simplex_count(), 128u);
}

TEST(DelaunayTriangulation, WorksAtTheEndsOfTheCoordinateDomain) {
  for (const double s : {0x1p-240, 0x1p-120, 0x1p120, 0x1p240}) {
    SCOPED_TRACE(s);
    DelaunayTriangulation dt;
    dt.Reset({{s * kLow[0], s * kLow[1]}}, {{s * kHigh[0], s * kHigh[1]}}, {0, 1, 2, 3});
    const auto points = DistinctPoints(Layout::kGrid, 5, 200);
    for (VertexIndex i = 0; i < points.size(); ++i) {
      dt.Insert(4 + i, {{s * points[i][0], s * points[i][1]}}, 0);
    }
    for (VertexIndex i = 0; i < points.size(); i += 3) dt.Remove(4 + i);
    std::string why;
    ASSERT_TRUE(dt.Check(&why)) << why;
  }
}

TEST(DelaunayTriangulation, InsertAtAcceptsAnyConflictingTriangle) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  const auto points = DistinctPoints(Layout::kBoxSides, seed, 60);
  DelaunayTriangulation dt = EmptyBox();
  std::vector<Point2> present;
  std::size_t choice = 0;
  for (VertexIndex i = 0; i < points.size(); ++i) {
    std::vector<SimplexIndex> conflicting;
    for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) {
      if (dt.Conflicts(t, points[i])) conflicting.push_back(t);
    }
    ASSERT_FALSE(conflicting.empty());
    const std::size_t expected = conflicting.size();
    dt.InsertAt(4 + i, points[i], conflicting[choice++ % conflicting.size()]);
    ASSERT_EQ(dt.deleted().size(), expected);
    ASSERT_EQ(dt.created().size(), expected + 2);
    for (std::size_t k = 0; k < dt.created().size(); ++k) {
      // Counter-clockwise around the new vertex, which is corner 2.
      const auto& v = dt.vertices(dt.created()[k]);
      ASSERT_EQ(v[2], 4 + i);
      ASSERT_EQ(v[1], dt.vertices(dt.created()[(k + 1) % dt.created().size()])[0]);
    }
    present.push_back(points[i]);
  }
  ExpectIsDelaunayOf(dt, present);
}

TEST(DelaunayTriangulation, LocateFindsATriangleThatHoldsThePoint) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const Layout layout : kAllLayouts) {
    const auto points = DistinctPoints(layout, seed, 300);
    const DelaunayTriangulation dt = Triangulate(points);
    LayoutSource queries(layout, seed + 1, 300);
    for (VertexIndex i = 0; i < points.size(); ++i) {
      // Generic points, and vertices themselves.
      const Point2 p = i % 2 == 0 ? queries.Next() : points[i];
      const SimplexIndex t = dt.Locate(p, 4 + static_cast<VertexIndex>(i * 7 % points.size()));
      ASSERT_FALSE(dt.IsInfinite(t));
      const auto& v = dt.vertices(t);
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_GE(Orientation(dt.position(v[k]), dt.position(v[(k + 1) % 3]), p), 0);
      }
    }
  }
}

TEST(DelaunayTriangulation, LocateReportsWhatLiesOutsideTheBox) {
  const DelaunayTriangulation dt = Triangulate(DistinctPoints(Layout::kBoxSides, 9, 100));
  for (const Point2 p : {Point2{{-5, 0}}, Point2{{0, 9}}, Point2{{3.001, 2}}, Point2{{3, -2.5}}}) {
    const SimplexIndex t = dt.Locate(p, 0);
    ASSERT_TRUE(dt.IsInfinite(t));
    ASSERT_TRUE(dt.Conflicts(t, p));
  }
}

TEST(DelaunayTriangulation, NextAroundTurnsCounterClockwiseThroughTheWholeStar) {
  const DelaunayTriangulation dt = Triangulate(DistinctPoints(Layout::kClusters, 2, 400));
  std::vector<std::size_t> degree(dt.vertex_count());
  std::size_t hull = 0;
  for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) {
    hull += dt.IsInfinite(t);
    for (const VertexIndex v : dt.vertices(t)) {
      if (v != kInfinite) ++degree[v];
    }
  }
  const auto walk = [&](VertexIndex v) {
    const auto start = dt.Around(v);
    auto c = start;
    std::size_t count = 0;
    do {
      const auto at = [&](int i) { return dt.vertices(c.simplex)[static_cast<std::size_t>(i)]; };
      EXPECT_EQ(at(c.index), v);
      const VertexIndex left = at(DelaunayTriangulation::PreviousIndex(c.index));
      c = dt.NextAround(c);
      EXPECT_EQ(at(DelaunayTriangulation::NextIndex(c.index)), left);
      ++count;
    } while (c != start && count < 10000);
    return count;
  };
  for (VertexIndex v = 0; v < dt.vertex_count(); ++v) ASSERT_EQ(walk(v), degree[v]);
  EXPECT_EQ(walk(kInfinite), hull);
}

TEST(DelaunayTriangulation, CachedCirclesNeverContradictTheExactTest) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::size_t useful = 0, close = 0;
  for (const Layout layout : kAllLayouts) {
    const DelaunayTriangulation dt = Triangulate(DistinctPoints(layout, seed, 500));
    dt.ForEachSimplex([&](SimplexIndex t) {
      if (std::isinf(dt.circle_error(t))) return;
      ++useful;
      const auto& v = dt.vertices(t);
      const Point2 center = dt.circumcenter(t);
      const double radius = std::sqrt(dt.squared_circumradius(t));
      for (int k = 0; k < 20; ++k) {
        // As near the circle as doubles allow, or a little off it, or anywhere.
        const double angle = std::uniform_real_distribution<double>(0, 6.3)(random);
        const double off = k < 8    ? 1
                           : k < 16 ? 1 + std::ldexp(1.0, -k * 3) * (k % 2 ? 1 : -1)
                                    : std::ldexp(1.0, k - 18);
        const Point2 p{{center[0] + off * radius * std::cos(angle),
                        center[1] + off * radius * std::sin(angle)}};
        const Point2 a = dt.position(v[0]), b = dt.position(v[1]), c = dt.position(v[2]);
        if (p == a || p == b || p == c) continue;
        const double dx = p[0] - center[0], dy = p[1] - center[1];
        close += std::fabs(dx * dx + dy * dy - radius * radius) <= dt.circle_error(t);
        ASSERT_EQ(dt.Conflicts(t, p), InCircle(a, b, c, p));
      }
    });
  }
  EXPECT_GT(useful, 1000u);
  EXPECT_GT(close, 100u);
}

TEST(DelaunayTriangulation, TagsStayUntilTheTriangleGoes) {
  DelaunayTriangulation dt = Triangulate(DistinctPoints(Layout::kUniform, 4, 50));
  for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) dt.set_tag(t, t + 1);
  dt.Insert(1000, {{0.501, 0.499}}, 0);
  std::size_t kept = 0;
  for (SimplexIndex t = 0; t < dt.simplex_limit(); ++t) kept += dt.tag(t) == t + 1;
  for (const SimplexIndex t : dt.created()) EXPECT_EQ(dt.tag(t), 0u);
  EXPECT_EQ(kept + dt.created().size(), dt.simplex_limit());
}

// --- Removal of vertices of great degree.

// 2 * count points on a circle of radius 5 * 13 * 17 * 29 / 64, exactly, as far as count
// Pythagorean pairs exist, about the center c.
std::vector<Point2> ExactCircle(const Point2& center, double unit) {
  const long r = 5L * 13 * 17 * 29;
  std::vector<Point2> points;
  for (long x = -r; x <= r; ++x) {
    const long y = std::lround(std::sqrt(static_cast<double>(r * r - x * x)));
    if (x * x + y * y != r * r) continue;
    for (const long s : {-y, y}) {
      points.push_back(
          {{center[0] + unit * static_cast<double>(x), center[1] + unit * static_cast<double>(s)}});
      if (y == 0) break;
    }
  }
  return points;
}

TEST(DelaunayRemoval, OfTheHubOfACocircularWheelLeavesTheUniqueTriangulation) {
  const Point2 hub{{0.5, 0.25}};
  const auto rim = ExactCircle(hub, 0x1p-16);
  ASSERT_GT(rim.size(), 100u);
  DelaunayTriangulation dt = Triangulate(rim);
  const auto expected = TrianglesOf(dt);
  dt.Insert(1000, hub, 4);
  EXPECT_EQ(dt.created().size(), rim.size());
  dt.Remove(1000);
  EXPECT_EQ(dt.deleted().size(), rim.size());
  EXPECT_EQ(dt.created().size(), rim.size() - 2);
  EXPECT_EQ(TrianglesOf(dt), expected);
  ExpectIsDelaunayOf(dt, rim);
}

TEST(DelaunayRemoval, OfAHullVertexOfGreatDegreeClosesTheHull) {
  const Point2 hub{{0.5, kLow[1]}};
  std::vector<Point2> rim;
  for (const Point2& p : ExactCircle(hub, 0x1p-16)) {
    if (p[1] >= kLow[1]) rim.push_back(p);
  }
  ASSERT_GT(rim.size(), 60u);
  DelaunayTriangulation dt = Triangulate(rim);
  const auto expected = TrianglesOf(dt);
  dt.Insert(1000, hub, 0);
  ASSERT_GT(dt.created().size(), 60u);
  dt.Remove(1000);
  EXPECT_EQ(TrianglesOf(dt), expected);
  ExpectIsDelaunayOf(dt, rim);
}

// Degrees on both sides of the limit between the two ways to fill a hole, the corners of
// the box among the rim.
TEST(DelaunayRemoval, OfTheMiddleOfABoxIsRightForEveryDegree) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (int count = 0; count < 120; ++count) {
    auto points = DistinctPoints(Layout::kCircle, seed + static_cast<std::uint64_t>(count), count);
    std::erase(points, Point2{{0.5, 0.5}});
    DelaunayTriangulation dt = Triangulate(points);
    const auto expected = TrianglesOf(dt);
    dt.Insert(1000, {{0.5, 0.5}}, 0);
    dt.Remove(1000);
    ASSERT_EQ(TrianglesOf(dt), expected) << count;
    ASSERT_NO_FATAL_FAILURE(ExpectIsDelaunayOf(dt, points));
  }
}

TEST(DelaunayRemoval, OfSideVerticesOneByOneRestoresTheBareBox) {
  DelaunayTriangulation dt = EmptyBox();
  VertexIndex v = 4;
  for (int i = 1; i < 16; ++i) {
    const double t = i / 4.0;
    dt.Insert(v++, {{kLow[0] + t, kLow[1]}}, 0);
    dt.Insert(v++, {{kHigh[0], kLow[1] + t}}, 0);
    dt.Insert(v++, {{kLow[0] + t, kHigh[1]}}, 0);
    dt.Insert(v++, {{kLow[0], kLow[1] + t}}, 0);
  }
  std::vector<VertexIndex> order(v - 4);
  std::iota(order.begin(), order.end(), VertexIndex{4});
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::shuffle(order.begin(), order.end(), random);
  for (const VertexIndex victim : order) {
    dt.Remove(victim);
    std::string why;
    ASSERT_TRUE(dt.Check(&why)) << why;
  }
  ExpectIsDelaunayOf(dt, {});
}

TEST(DelaunayRemoval, ReusesTriangles) {
  const auto points = DistinctPoints(Layout::kUniform, 8, 1000);
  DelaunayTriangulation dt = Triangulate(points);
  const SimplexIndex limit = dt.simplex_limit();
  for (int round = 0; round < 3; ++round) {
    for (VertexIndex i = 0; i < points.size(); ++i) dt.Remove(4 + i);
    ASSERT_EQ(dt.simplex_count(), 2u);
    for (VertexIndex i = 0; i < points.size(); ++i) dt.Insert(4 + i, points[i], 0);
  }
  EXPECT_EQ(dt.simplex_limit(), limit);
  ExpectIsDelaunayOf(dt, points);
}

// --- The order of batches.

TEST(DelaunayInsertOrder, IsAPermutationThatIgnoresTheOrderOfTheList) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const Layout layout : kAllLayouts) {
    auto points = DistinctPoints(layout, seed, 3000);
    const auto order = InsertOrder(points);
    auto sorted = order;
    std::sort(sorted.begin(), sorted.end());
    for (std::uint32_t i = 0; i < points.size(); ++i) ASSERT_EQ(sorted[i], i);
    ASSERT_EQ(sorted.size(), points.size());
  }
  EXPECT_TRUE(InsertOrder(std::span<const Point2>{}).empty());
  EXPECT_EQ(InsertOrder(std::vector<Point2>(50, Point2{{1, 1}})).size(), 50u);
}

TEST(DelaunayInsertOrder, IsAPermutationInSpaceToo) {
  std::mt19937_64 random(NewSeed());
  std::vector<geometry::Point3> points;
  for (int i = 0; i < 3000; ++i) {
    const double scale = i % 3 == 0 ? 1 : 0x1p-60;
    geometry::Point3 p;
    for (double& x : p.c) x = scale * static_cast<double>(random() % 1000);
    points.push_back(p);
  }
  auto order = InsertOrder(points);
  std::sort(order.begin(), order.end());
  ASSERT_EQ(order.size(), points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) ASSERT_EQ(order[i], i);
}

// Half of the points on a circle, half near its centre on a line that the curve follows. If no
// point of one kind came among the other's, each would meet half a circle of triangles. A client
// that knows the hash of points can make any of its bits alike.
TEST(DelaunayInsertOrder, NoChoiceOfHashesMakesInsertionsLong) {
  for (const int direction : {0, 1, 2, 3}) {
    std::vector<double> each;
    for (const int n : {5'000, 10'000, 20'000}) {
      std::mt19937_64 random(17);
      std::uniform_real_distribution<double> uniform(0, 1);
      std::vector<Point2> points;
      while (points.size() < static_cast<std::size_t>(n)) {
        const double t = uniform(random), angle = 6.283185307179586 * t;
        const double along = 1e-3 * (t - 0.5), x = direction % 2 == 0 ? along : 0,
                     y = direction % 2 == 0 ? 0 : along, sign = direction < 2 ? 1 : -1;
        const Point2 p = points.size() % 2 == 0
                             ? Point2{{0.5 + 0.4 * std::cos(angle), 0.5 + 0.4 * std::sin(angle)}}
                             : Point2{{0.5 + sign * x + 1e-9 * angle, 0.5 + sign * y}};
        // In the last round, if the last bits decide, or the leading ones.
        const std::uint64_t hash = geometry::HashOf(p);
        if (hash % 16 != 0 && hash >> 60 != 0) points.push_back(p);
      }
      DelaunayTriangulation dt;
      dt.Reset({{0, 0}}, {{1, 1}}, {0, 1, 2, 3});
      double made = 0;
      VertexIndex near = 0;
      for (const std::uint32_t i : InsertOrder(points)) {
        dt.Insert(i + 4, points[i], near);
        near = i + 4;
        made += static_cast<double>(dt.created().size());
      }
      each.push_back(made / n);
    }
    // O(lg n) each.
    EXPECT_LT(each.back(), 20) << "direction " << direction;
    EXPECT_LT(each.back(), 2 * each.front()) << "direction " << direction;
  }
}

// Successive points are near each other, in clusters within clusters far below the first
// curve's cells too: the way along the order is a small multiple of that of a shortest
// tour, about 0.7 sqrt(area * count), against half a side per step at random.
TEST(DelaunayInsertOrder, IsShortWithinNestedClusters) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  constexpr double kInner = 0x1p-60;
  std::vector<Point2> points;
  for (const double side : {1.0, 0x1p-30, kInner}) {
    for (int i = 0; i < 10000; ++i) {
      points.push_back({{side * uniform(random), side * uniform(random)}});
    }
  }
  double way = 0;
  const Point2* last = nullptr;
  for (const std::uint32_t i : InsertOrder(points)) {
    if (points[i][0] >= kInner) continue;  // the way within the innermost only
    if (last != nullptr) way += std::sqrt(geometry::SquaredDistance(*last, points[i]));
    last = &points[i];
  }
  EXPECT_LT(way, kInner * 4 * std::sqrt(10000.0));
}

}  // namespace
}  // namespace dynmesh::delaunay::delaunay_triangulation_test
