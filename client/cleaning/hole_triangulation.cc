#include "client/cleaning/hole_triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "client/cleaning/vectors3.h"

namespace dynmesh::cleaning {

namespace {

// Of all three angles; infinite without area.
std::array<double, 3> CotangentsOf(const TriangleCorners& t) {
  const Point3 normal = NormalOf(t[0], t[1], t[2]);
  const double area2 = std::sqrt(Dot(normal, normal));
  std::array<double, 3> cotangents;
  cotangents.fill(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; area2 > 0 && i < 3; ++i) {
    const Point3 &p = t[i], &q = t[(i + 1) % 3], &r = t[(i + 2) % 3];
    cotangents[i] = Dot(Minus(q, p), Minus(r, p)) / area2;
  }
  return cotangents;
}

}  // namespace

double LargestCotangent(const TriangleCorners& triangle) {
  return std::ranges::max(CotangentsOf(triangle));
}

double LeastCotangent(const TriangleCorners& triangle) {
  return std::ranges::min(CotangentsOf(triangle));
}

double SquaredCircumradius(const TriangleCorners& t) {
  const Point3 normal = NormalOf(t[0], t[1], t[2]);
  const double area2 = std::sqrt(Dot(normal, normal));
  if (!(area2 > 0)) return std::numeric_limits<double>::infinity();
  const double root = std::sqrt(SquaredDistance<3>(t[0], t[1])) / area2 *
                      std::sqrt(SquaredDistance<3>(t[1], t[2])) *
                      std::sqrt(SquaredDistance<3>(t[2], t[0])) / 2;
  return root * root;
}

double HeightOf(const TriangleCorners& t) {
  const Point3 normal = NormalOf(t[0], t[1], t[2]);
  const double longest2 = std::max({SquaredDistance<3>(t[0], t[1]), SquaredDistance<3>(t[1], t[2]),
                                    SquaredDistance<3>(t[2], t[0])});
  return std::sqrt(Dot(normal, normal) / longest2);
}

namespace {

// The value of a part of a triangulation from its two smaller parts and its triangle; less is
// better.
struct ByLeastAngle {
  static double Of(double a, double b, const TriangleCorners& t) {
    return std::max({a, b, LargestCotangent(t)});
  }
};
struct ByArea {
  static double Of(double a, double b, const TriangleCorners& t) {
    const Point3 normal = NormalOf(t[0], t[1], t[2]);
    return a + b + std::sqrt(Dot(normal, normal));
  }
};

using Triple = std::array<std::size_t, 3>;

template <class Measure>
std::vector<Triple> Triangulate(std::span<const Point3> chain, std::span<const Triple> forbidden) {
  const std::size_t n = chain.size();
  // Of the part from i to j: its value, and the third corner at its side; 0: there is none.
  struct Best {
    double value = 0;
    std::size_t apex = 0;
  };
  std::vector<Best> best(n * n);
  for (std::size_t length = 2; length < n; ++length) {
    for (std::size_t i = 0; i + length < n; ++i) {
      const std::size_t j = i + length;
      Best& of = best[i * n + j];
      for (std::size_t k = i + 1; k < j; ++k) {
        const Best &left = best[i * n + k], &right = best[k * n + j];
        if ((k > i + 1 && left.apex == 0) || (j > k + 1 && right.apex == 0)) continue;
        const double value = Measure::Of(left.value, right.value, {chain[i], chain[k], chain[j]});
        if (of.apex != 0 && !(value < of.value)) continue;
        if (std::ranges::find(forbidden, Triple{i, k, j}) != forbidden.end()) continue;
        of = {value, k};
      }
    }
  }
  if (best[n - 1].apex == 0) return {};
  std::vector<Triple> triangles;
  std::vector<std::pair<std::size_t, std::size_t>> parts = {{0, n - 1}};
  while (!parts.empty()) {
    const auto [i, j] = parts.back();
    parts.pop_back();
    if (j < i + 2) continue;
    const std::size_t k = best[i * n + j].apex;
    triangles.push_back({i, k, j});
    parts.emplace_back(i, k);
    parts.emplace_back(k, j);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace

std::vector<Triple> TriangulateHole(std::span<const Point3> chain, HoleMeasure measure,
                                    std::span<const Triple> forbidden) {
  return measure == HoleMeasure::kArea ? Triangulate<ByArea>(chain, forbidden)
                                       : Triangulate<ByLeastAngle>(chain, forbidden);
}

}  // namespace dynmesh::cleaning
