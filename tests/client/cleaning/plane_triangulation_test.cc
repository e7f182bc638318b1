#include "client/cleaning/plane_triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

namespace dynmesh::cleaning {
namespace {

using Vertex = PlaneTriangulation::Vertex;

double Area(const Point& a, const Point& b, const Point& c) {
  return ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
}

// In integers, so exact.
double InCircle(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double ax = a[0] - d[0], ay = a[1] - d[1], bx = b[0] - d[0], by = b[1] - d[1],
               cx = c[0] - d[0], cy = c[1] - d[1];
  return (ax * ax + ay * ay) * (bx * cy - cx * by) + (bx * bx + by * by) * (cx * ay - ax * cy) +
         (cx * cx + cy * cy) * (ax * by - bx * ay);
}

struct Made {
  PlaneTriangulation plane;
  std::vector<Point> points;
};

Made MadeOf(const std::vector<Point>& inner, bool delaunay) {
  Made made;
  made.points = {{-400, -400}, {800, -400}, {-400, 800}};
  for (std::uint32_t k = 0; k < 3; ++k) made.plane.AddVertex(made.points[k], 1000 + k);
  made.plane.AddTriangle(0, 1, 2);
  for (const Point& p : inner) {
    const Vertex v = made.plane.AddVertex(p, static_cast<std::uint32_t>(made.points.size()));
    made.points.push_back(p);
    EXPECT_TRUE(delaunay ? made.plane.InsertDelaunay(v) : made.plane.Insert(v));
  }
  return made;
}

std::vector<Point> RandomPoints(std::uint64_t seed, int n, int extent) {
  std::mt19937_64 random(seed);
  std::set<Point> points;
  while (static_cast<int>(points.size()) < n) {
    const double x = static_cast<double>(random() % static_cast<std::uint64_t>(extent));
    const double y = static_cast<double>(random() % static_cast<std::uint64_t>(extent));
    points.insert({x, y});
  }
  return {points.begin(), points.end()};
}

std::set<std::set<Vertex>> SetOf(const PlaneTriangulation& plane) {
  std::set<std::set<Vertex>> triangles;
  for (const auto& t : plane.Triangles()) triangles.insert({t.begin(), t.end()});
  return triangles;
}

TEST(PlaneTriangulation, IsDelaunayHoweverPointsCome) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    // Small extents: many points are on a line or a circle.
    const std::vector<Point> points = RandomPoints(seed, 30, seed % 2 == 0 ? 7 : 100);
    Made first = MadeOf(points, true), second = MadeOf(points, false);
    second.plane.MakeDelaunay();
    EXPECT_EQ(SetOf(first.plane), SetOf(second.plane));
    double area = 0;
    for (const auto& t : first.plane.Triangles()) {
      const Point &a = first.points[t[0]], &b = first.points[t[1]], &c = first.points[t[2]];
      EXPECT_GT(Area(a, b, c), 0);
      area += Area(a, b, c);
      for (const Point& d : first.points) EXPECT_LE(InCircle(a, b, c, d), 0);
    }
    EXPECT_EQ(area, 720000);
  }
}

TEST(PlaneTriangulation, FixedEdgesAreThereUnlessTheyCross) {
  int fixed = 0, refused = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    Made made = MadeOf(RandomPoints(seed, 25, 30), true);
    std::mt19937_64 random(seed);
    std::vector<std::pair<Vertex, Vertex>> edges;
    for (int i = 0; i < 12; ++i) {
      const auto a = static_cast<Vertex>(3 + random() % 25),
                 b = static_cast<Vertex>(3 + random() % 25);
      if (a == b) continue;
      if (made.plane.Fix(a, b, true)) {
        edges.emplace_back(a, b);
      } else {
        ++refused;
      }
    }
    made.plane.MakeDelaunay();
    double area = 0;
    for (const auto& t : made.plane.Triangles()) {
      EXPECT_GT(Area(made.points[t[0]], made.points[t[1]], made.points[t[2]]), 0);
      area += Area(made.points[t[0]], made.points[t[1]], made.points[t[2]]);
    }
    EXPECT_EQ(area, 720000);
    for (const auto& [a, b] : edges) {
      EXPECT_TRUE(made.plane.Opposite(a, b).has_value());
      EXPECT_TRUE(made.plane.IsFixed(a, b));
      ++fixed;
    }
  }
  EXPECT_GT(fixed, 100);
  EXPECT_GT(refused, 20);
}

TEST(PlaneTriangulation, ABorderRunsThroughItsPointsOrTheOppositeCorner) {
  PlaneTriangulation plane;
  const Vertex a = plane.AddVertex({0, 0}, 0), b = plane.AddVertex({4, 0}, 1),
               c = plane.AddVertex({2, 3}, 2);
  plane.AddTriangle(a, b, c);
  const Vertex v = plane.AddVertex({1, -0.001}, 3);  // slightly outside
  EXPECT_EQ(plane.SplitBorder(a, b, v), v);
  EXPECT_EQ(SetOf(plane), (std::set<std::set<Vertex>>{{a, v, c}, {v, b, c}}));
  // The part bvc goes: its edge bv is to run through c.
  const Vertex w = plane.AddVertex({2, 3}, 2);
  EXPECT_EQ(plane.SplitBorder(b, v, w), c);
  EXPECT_EQ(SetOf(plane), (std::set<std::set<Vertex>>{{a, v, c}}));
}

TEST(PlaneTriangulation, ABorderThatHasGoneThroughTheOppositeCornerGoesOn) {
  PlaneTriangulation plane;
  const Vertex a = plane.AddVertex({0, 0}, 0), b = plane.AddVertex({4, 0}, 1),
               c = plane.AddVertex({2, 0.001}, 2);
  plane.AddTriangle(a, b, c);
  // From b to a through c, then through another point: between that and ca a triangle is left.
  EXPECT_EQ(plane.SplitBorder(a, b, plane.AddVertex({2, 0.001}, 2)), c);
  EXPECT_TRUE(SetOf(plane).empty());
  const Vertex v = plane.AddVertex({1, -0.001}, 3);
  EXPECT_EQ(plane.SplitBorder(a, c, v), v);
  EXPECT_EQ(SetOf(plane), (std::set<std::set<Vertex>>{{a, v, c}}));
}

}  // namespace
}  // namespace dynmesh::cleaning
