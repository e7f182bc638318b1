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

std::vector<std::array<std::size_t, 3>> TriangulateHole(std::span<const Point3> chain) {
  const std::size_t n = chain.size();
  // Of the part from i to j: the cotangent of its least angle, and the third corner at its side.
  struct Best {
    double cotangent = 0;
    std::size_t apex = 0;
  };
  std::vector<Best> best(n * n);
  for (std::size_t length = 2; length < n; ++length) {
    for (std::size_t i = 0; i + length < n; ++i) {
      const std::size_t j = i + length;
      Best& of = best[i * n + j];
      for (std::size_t k = i + 1; k < j; ++k) {
        const double cotangent = std::max({best[i * n + k].cotangent, best[k * n + j].cotangent,
                                           LargestCotangent({chain[i], chain[k], chain[j]})});
        if (k == i + 1 || cotangent < of.cotangent) of = {cotangent, k};
      }
    }
  }
  std::vector<std::array<std::size_t, 3>> triangles;
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

}  // namespace dynmesh::cleaning
