// Properties of a Delaunay tetrahedralisation, tested independently of the code under test, and
// point sets that are hard for it.
#ifndef DYNMESH_TESTS_CORE_DELAUNAY_TETRAHEDRA_ORACLE_H_
#define DYNMESH_TESTS_CORE_DELAUNAY_TETRAHEDRA_ORACLE_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::delaunay::testing {

using geometry::Point3;
using VertexIndex = DelaunayTetrahedralization::VertexIndex;
using SimplexIndex = DelaunayTetrahedralization::SimplexIndex;

// A tetrahedron by the positions of its corners, ascending.
using PlacedTetrahedron = std::array<Point3, 4>;
using TetrahedronSet = std::set<PlacedTetrahedron>;

inline TetrahedronSet TetrahedraOf(const DelaunayTetrahedralization& dt) {
  TetrahedronSet result;
  dt.ForEachSimplex([&](SimplexIndex t) {
    PlacedTetrahedron placed;
    for (std::size_t i = 0; i < 4; ++i) placed[i] = dt.position(dt.vertices(t)[i]);
    std::sort(placed.begin(), placed.end());
    result.insert(placed);
  });
  return result;
}

// By definition: all quadruples with nothing in their sphere. O(n^5).
inline TetrahedronSet BruteForceDelaunay(std::vector<Point3> points) {
  std::sort(points.begin(), points.end());
  TetrahedronSet result;
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      for (std::size_t k = j + 1; k < n; ++k) {
        for (std::size_t l = k + 1; l < n; ++l) {
          Point3 a = points[i], b = points[j];
          const Point3& c = points[k];
          const Point3& d = points[l];
          const int side = Orientation(a, b, c, d);
          if (side == 0) continue;
          if (side < 0) std::swap(a, b);
          if (std::none_of(points.begin(), points.end(), [&](const Point3& e) {
                return e != a && e != b && e != c && e != d && InSphere(a, b, c, d, e);
              })) {
            result.insert({points[i], points[j], points[k], points[l]});
          }
        }
      }
    }
  }
  return result;
}

enum class Layout {
  kUniform,
  kGrid,           // 3^3 to 5^3: coplanar, collinear, cospherical throughout
  kBoxFaces,       // most of them on the faces and edges of the box
  kSphere,         // of integers, on one sphere exactly, and its middle
  kLineAndCircle,  // quadratically many tetrahedra
  kPairs,          // pairs 2^-40 apart
  kClusters,       // little grids of mesh 2^-30, some in the middle of a face or an edge
  kSlivers         // planes and lines disturbed by ulps: as flat as doubles allow
};

inline constexpr Layout kAllLayouts[] = {
    Layout::kUniform,       Layout::kGrid,  Layout::kBoxFaces, Layout::kSphere,
    Layout::kLineAndCircle, Layout::kPairs, Layout::kClusters, Layout::kSlivers};

inline std::string LayoutName(Layout layout) {
  static constexpr const char* kNames[] = {"Uniform",       "Grid",  "BoxFaces", "Sphere",
                                           "LineAndCircle", "Pairs", "Clusters", "Slivers"};
  return kNames[static_cast<int>(layout)];
}

inline constexpr Point3 kLow{{-2, -1, -2}};
inline constexpr Point3 kHigh{{2, 5, 2}};

inline std::vector<Point3> Corners() {
  std::vector<Point3> corners;
  for (unsigned i = 0; i < 8; ++i) {
    corners.push_back(
        {{(i & 1 ? kHigh : kLow)[0], (i & 2 ? kHigh : kLow)[1], (i & 4 ? kHigh : kLow)[2]}});
  }
  return corners;
}

// x^2 + y^2 + z^2 = 21^2: 8 times (1,4,20) (4,8,19) (4,13,16) (6,9,18) (7,14,14) (8,11,16), ...
inline std::vector<Point3> IntegerSphere(const Point3& center, double unit) {
  constexpr int kRadius = 21;
  std::vector<Point3> points;
  for (int x = -kRadius; x <= kRadius; ++x) {
    for (int y = -kRadius; y <= kRadius; ++y) {
      for (int z = -kRadius; z <= kRadius; ++z) {
        if (x * x + y * y + z * z != kRadius * kRadius) continue;
        points.push_back({{center[0] + unit * x, center[1] + unit * y, center[2] + unit * z}});
      }
    }
  }
  return points;
}

// Points in the closed box kLow..kHigh; may repeat.
class LayoutSource {
 public:
  LayoutSource(Layout layout, std::uint64_t seed)
      : layout_(layout),
        random_(seed),
        side_(static_cast<int>(2 + seed % 3)),
        sphere_(IntegerSphere({{0, 1, 0}}, 1.0 / 16)) {}

  Point3 Next() {
    switch (layout_) {
      case Layout::kUniform:
        return {{Uniform(), Uniform(), Uniform()}};
      case Layout::kGrid:
        return {{kLow[0] + Integer(0, side_), kLow[1] + Integer(0, side_),
                 kLow[2] + Integer(0, side_)}};
      case Layout::kBoxFaces: {
        Point3 p;
        for (int i = 0; i < 3; ++i) p[i] = kLow[i] + (kHigh[i] - kLow[i]) * Integer(0, 8) / 8;
        for (int k = Integer(0, 2); k > 0; --k) {
          const int axis = Integer(0, 2);
          p[axis] = Integer(0, 1) ? kLow[axis] : kHigh[axis];
        }
        return p;
      }
      case Layout::kSphere:
        if (Integer(0, 30) == 0) return {{0, 1, 0}};
        return sphere_[static_cast<std::size_t>(Integer(0, int(sphere_.size()) - 1))];
      case Layout::kLineAndCircle: {
        if (Integer(0, 1)) return {{0, 0, Uniform()}};
        const double angle = 2 * std::numbers::pi * Uniform();
        return {{std::cos(angle), std::sin(angle), 0}};
      }
      case Layout::kPairs: {
        if (Integer(0, 1) != 0) return last_ = {{Uniform(), Uniform(), Uniform()}};
        Point3 p = last_;
        for (double& x : p.c) x += 0x1p-40 * Integer(-1, 1);
        return p;
      }
      case Layout::kClusters: {
        Point3 p{{0.125, Integer(0, 1) ? kLow[1] : 0.3, Integer(0, 1) ? kLow[2] : 0.7}};
        p[0] += 0x1p-30 * Integer(-4, 4);
        p[1] += 0x1p-30 * Integer(0, 4);
        p[2] += 0x1p-30 * Integer(0, 4);
        return p;
      }
      case Layout::kSlivers: {
        const double t = Integer(0, 9) / 9.0, u = Integer(0, 9) / 9.0;
        Point3 p{{0.1 + t, 0.1 + u / 3, 0.1 + t / 7 + u / 9}};
        if (Integer(0, 1)) p = {{0.7, t, 0.3 + t / 3}};
        for (double& x : p.c) x += std::ldexp(Integer(-2, 2), -53);
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
  int side_;
  std::vector<Point3> sphere_;
  Point3 last_{{0.5, 0.5, 0.5}};
};

inline std::vector<Point3> DistinctPoints(Layout layout, std::uint64_t seed, int count) {
  LayoutSource source(layout, seed);
  const std::vector<Point3> corners = Corners();
  std::set<Point3> seen(corners.begin(), corners.end());
  std::vector<Point3> points;
  for (int i = 0; i < count; ++i) {
    const Point3 p = source.Next();
    if (seen.insert(p).second) points.push_back(p);
  }
  return points;
}

inline DelaunayTetrahedralization EmptyBox() {
  DelaunayTetrahedralization dt;
  dt.Reset(kLow, kHigh, {0, 1, 2, 3, 4, 5, 6, 7});
  return dt;
}

inline std::vector<VertexIndex> IndicesFrom8(std::size_t count) {
  std::vector<VertexIndex> indices(count);
  std::iota(indices.begin(), indices.end(), VertexIndex{8});
  return indices;
}

inline DelaunayTetrahedralization Tetrahedralize(const std::vector<Point3>& points) {
  DelaunayTetrahedralization dt = EmptyBox();
  dt.InsertAll(IndicesFrom8(points.size()), points);
  return dt;
}

inline void ExpectSound(const DelaunayTetrahedralization& dt) {
  std::string why;
  ASSERT_TRUE(dt.Check(&why)) << why;
}

}  // namespace dynmesh::delaunay::testing

#endif  // DYNMESH_TESTS_CORE_DELAUNAY_TETRAHEDRA_ORACLE_H_
