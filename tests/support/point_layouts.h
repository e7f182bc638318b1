// Distinct points in the unit square (cube, ...), for programs of any dimension.
#ifndef DYNMESH_TESTS_SUPPORT_POINT_LAYOUTS_H_
#define DYNMESH_TESTS_SUPPORT_POINT_LAYOUTS_H_

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::test {

enum class Layout {
  kUniform,
  kClustered,      // towards the middle, over 20 octaves
  kCircle,         // in a plane
  kCircleAndLine,  // half of the points each; in 3D an axis
  kLine,           // the diagonal
  kGrid,
  kTwoScales,  // half of them in a box of side 2^-14
  kPair,       // two, at a distance of 2^-30
  kEmpty,
};
inline constexpr Layout kLayouts[] = {Layout::kUniform,       Layout::kClustered, Layout::kCircle,
                                      Layout::kCircleAndLine, Layout::kLine,      Layout::kGrid,
                                      Layout::kTwoScales,     Layout::kPair,      Layout::kEmpty};

inline const char* NameOf(Layout layout) {
  constexpr const char* kNames[] = {"uniform",         "clustered", "circle",
                                    "circle and line", "line",      "grid",
                                    "two scales",      "pair",      "empty"};
  return kNames[static_cast<int>(layout)];
}

// About n points, sorted. Deterministic for a seed.
template <int D>
std::vector<geometry::Point<D>> PointsOf(Layout layout, int n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> any(0, 1);
  std::set<geometry::Point<D>> points;
  const int side = static_cast<int>(std::round(std::pow(n, 1.0 / D)));
  if (layout == Layout::kEmpty) n = 0;
  if (layout == Layout::kPair) n = 2;
  for (int i = 0; i < n; ++i) {
    geometry::Point<D> p;
    for (int k = 0; k < D; ++k) p[k] = any(random);
    const double along = (i + 0.5) / n, angle = 2 * std::numbers::pi * i / n;
    const auto circle = [&] {
      p.c.fill(0.5);
      p[0] += 0.5 * std::cos(angle), p[1] += 0.5 * std::sin(angle);
    };
    switch (layout) {
      case Layout::kUniform:
      case Layout::kEmpty:
        break;
      case Layout::kClustered:
        for (int k = 0; k < D; ++k) p[k] = 0.5 + (p[k] - 0.5) * std::exp2(-20 * p[0] * p[0]);
        break;
      case Layout::kCircle:
        circle();
        break;
      case Layout::kCircleAndLine:
        if (i % 2 == 0) {
          p.c.fill(0.5);
          p[D - 1] = along;
        } else {
          circle();
        }
        break;
      case Layout::kLine:
        p.c.fill(along);
        break;
      case Layout::kGrid:
        for (int k = 0, rest = i; k < D; ++k, rest /= side) p[k] = (rest % side + 0.5) / side;
        break;
      case Layout::kTwoScales:
        if (i % 2 == 0) {
          for (int k = 0; k < D; ++k) p[k] = 0.7 + p[k] * 0x1p-14;
        }
        break;
      case Layout::kPair:
        if (i == 1) {
          p = *points.begin();
          p[0] += 0x1p-30;
        }
        break;
    }
    points.insert(p);
  }
  return {points.begin(), points.end()};
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_POINT_LAYOUTS_H_
