// Properties of a Delaunay triangulation, tested independently of the code under test, and point
// sets that are hard for it.
#ifndef DYNMESH_TESTS_CORE_DELAUNAY_DELAUNAY_ORACLE_H_
#define DYNMESH_TESTS_CORE_DELAUNAY_DELAUNAY_ORACLE_H_

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/delaunay/delaunay_triangulation.h"
#include "core/geometry/predicates.h"

namespace dynmesh::delaunay::testing {

using geometry::Point2;
using VertexIndex = DelaunayTriangulation::VertexIndex;
using SimplexIndex = DelaunayTriangulation::SimplexIndex;

// A triangle by the positions of its corners, counter-clockwise, the least first.
using PlacedTriangle = std::array<Point2, 3>;
using TriangleSet = std::set<PlacedTriangle>;

inline PlacedTriangle Canonical(PlacedTriangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

inline TriangleSet TrianglesOf(const DelaunayTriangulation& dt) {
  TriangleSet result;
  dt.ForEachSimplex([&](SimplexIndex t) {
    const auto& v = dt.vertices(t);
    result.insert(Canonical({dt.position(v[0]), dt.position(v[1]), dt.position(v[2])}));
  });
  return result;
}

// By definition: all triples with nothing in their circle. O(n^4).
inline TriangleSet BruteForceDelaunay(const std::vector<Point2>& points) {
  TriangleSet result;
  for (const Point2& a : points) {
    for (const Point2& b : points) {
      for (const Point2& c : points) {
        if (!(a < b && a < c) || Orientation(a, b, c) <= 0) continue;
        if (std::none_of(points.begin(), points.end(), [&](const Point2& d) {
              return d != a && d != b && d != c && InCircle(a, b, c, d);
            })) {
          result.insert({a, b, c});
        }
      }
    }
  }
  return result;
}

// By CGAL, which breaks ties by the lexicographic order too.
inline TriangleSet CgalDelaunay(const std::vector<Point2>& points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  CGAL::Delaunay_triangulation_2<Kernel> dt;
  std::vector<Kernel::Point_2> list;
  for (const Point2& p : points) list.emplace_back(p[0], p[1]);
  dt.insert(list.begin(), list.end());
  TriangleSet result;
  for (auto f = dt.finite_faces_begin(); f != dt.finite_faces_end(); ++f) {
    PlacedTriangle t;
    for (int i = 0; i < 3; ++i) {
      t[static_cast<std::size_t>(i)] = {{f->vertex(i)->point().x(), f->vertex(i)->point().y()}};
    }
    result.insert(Canonical(t));
  }
  return result;
}

enum class Layout {
  kUniform,
  kGrid,      // collinear and cocircular throughout
  kCircle,    // on a circle as far as doubles go, and its middle
  kBoxSides,  // half of them on the sides of the box
  kPairs,     // pairs 2^-40 apart
  kClusters,  // little grids of mesh 2^-30, some near the middle of a side
  kNeedles    // lines disturbed by ulps: triangles as flat as doubles allow
};

inline constexpr Layout kAllLayouts[] = {Layout::kUniform,  Layout::kGrid,  Layout::kCircle,
                                         Layout::kBoxSides, Layout::kPairs, Layout::kClusters,
                                         Layout::kNeedles};

inline std::string LayoutName(Layout layout) {
  static constexpr const char* kNames[] = {"Uniform", "Grid",     "Circle", "BoxSides",
                                           "Pairs",   "Clusters", "Needles"};
  return kNames[static_cast<int>(layout)];
}

inline constexpr Point2 kLow{{-1, -2}};
inline constexpr Point2 kHigh{{3, 2}};

inline std::vector<Point2> Corners() {
  return {kLow, {{kHigh[0], kLow[1]}}, kHigh, {{kLow[0], kHigh[1]}}};
}

// Points in the closed box kLow..kHigh; may repeat.
class LayoutSource {
 public:
  LayoutSource(Layout layout, std::uint64_t seed, int size)
      : layout_(layout), random_(seed), size_(size) {}

  Point2 Next() {
    switch (layout_) {
      case Layout::kUniform:
        return {{Uniform(), Uniform()}};
      case Layout::kGrid: {
        const int side = std::clamp(static_cast<int>(std::sqrt(size_)), 3, 64);
        return {{kLow[0] + 4.0 * Integer(0, side) / 64, kLow[1] + 4.0 * Integer(0, side) / 64}};
      }
      case Layout::kCircle: {
        if (Integer(0, 30) == 0) return {{0.5, 0.5}};
        const double angle = 2 * std::numbers::pi * Uniform();
        return {{0.5 + 0.5 * std::cos(angle), 0.5 + 0.5 * std::sin(angle)}};
      }
      case Layout::kBoxSides: {
        const double step = 1.0 / 16;
        Point2 p{{kLow[0] + Integer(0, 64) * step, kLow[1] + Integer(0, 64) * step}};
        const int side = Integer(0, 7);
        if (side < 4) p[side % 2] = side < 2 ? kLow[side % 2] : kHigh[side % 2];
        return p;
      }
      case Layout::kPairs: {
        if (Integer(0, 1) != 0) return last_ = {{Uniform(), Uniform()}};
        return {{last_[0] + 0x1p-40 * Integer(-1, 1), last_[1] + 0x1p-40 * Integer(-1, 1)}};
      }
      case Layout::kClusters: {
        const Point2 center{{0.125 + Integer(0, 2), Integer(0, 1) ? kLow[1] : 0.3}};
        return {{center[0] + 0x1p-30 * Integer(-9, 9), center[1] + 0x1p-30 * Integer(0, 9)}};
      }
      case Layout::kNeedles: {
        const double t = Integer(0, 40) / 40.0;
        Point2 p = Integer(0, 1) ? Point2{{0.1 + t, 0.1 + t / 3}} : Point2{{0.7, t}};
        for (int i = 0; i < 2; ++i) p[i] += std::ldexp(Integer(-2, 2), -53);
        return p;
      }
    }
    return {};
  }

 private:
  double Uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  int Integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  Layout layout_;
  std::mt19937_64 random_;
  int size_;
  Point2 last_{{0.5, 0.5}};
};

inline std::vector<Point2> DistinctPoints(Layout layout, std::uint64_t seed, int count) {
  LayoutSource source(layout, seed, count);
  const std::vector<Point2> corners = Corners();
  std::set<Point2> seen(corners.begin(), corners.end());
  std::vector<Point2> points;
  for (int i = 0; i < count; ++i) {
    const Point2 p = source.Next();
    if (seen.insert(p).second) points.push_back(p);
  }
  return points;
}

inline DelaunayTriangulation EmptyBox() {
  DelaunayTriangulation dt;
  dt.Reset(kLow, kHigh, {0, 1, 2, 3});
  return dt;
}

}  // namespace dynmesh::delaunay::testing

#endif  // DYNMESH_TESTS_CORE_DELAUNAY_DELAUNAY_ORACLE_H_
