#include "core/coplanar/facet_rings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/base/rings.h"
#include "core/geometry/predicates.h"

namespace dynmesh::coplanar {

using geometry::Point2;
using geometry::Point3;

namespace {

// The limit of validation; the predicates allow 2^250.
constexpr double kMaxMagnitude = 0x1p200;
constexpr double kMinMagnitude = 0x1p-200;

bool IsCorner(const PointRing& ring, const Point3& position) {
  return std::find(ring.begin(), ring.end(), position) != ring.end();
}

}  // namespace

bool IsInDomain(const std::array<double, 3>& position) {
  return std::all_of(position.begin(), position.end(), [](double c) {
    return c == 0 || (std::abs(c) >= kMinMagnitude && std::abs(c) <= kMaxMagnitude);
  });
}

std::array<Point3, 3> LeastCorner(const PointRing& ring, AxisView view) {
  const std::size_t n = ring.size();
  std::size_t least = 0;
  for (std::size_t i = 1; i < n; ++i) {
    if (view.Of(ring[i]) < view.Of(ring[least])) least = i;
  }
  return {ring[(least + n - 1) % n], ring[least], ring[(least + 1) % n]};
}

int SignOf(const PointRing& ring, AxisView view) {
  if (ring.size() < 3) return 0;
  const auto [before, least, behind] = LeastCorner(ring, view);
  return geometry::Orientation(view.Of(before), view.Of(least), view.Of(behind));
}

std::array<double, 3> AreaVector(const PointRing& ring) {
  std::array<double, 3> sum{};
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    std::array<double, 3> a{}, b{};
    for (int k = 0; k < 3; ++k) {
      a[static_cast<std::size_t>(k)] = ring[i][k] - ring[0][k];
      b[static_cast<std::size_t>(k)] = ring[i + 1][k] - ring[0][k];
    }
    sum[0] += a[1] * b[2] - a[2] * b[1];
    sum[1] += a[2] * b[0] - a[0] * b[2];
    sum[2] += a[0] * b[1] - a[1] * b[0];
  }
  return sum;
}

std::optional<AxisView> ViewOf(const PointRing& ring) {
  const std::array<double, 3> area = AreaVector(ring);
  std::array<int, 3> axes = {0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) {
    return std::abs(area[static_cast<std::size_t>(a)]) >
           std::abs(area[static_cast<std::size_t>(b)]);
  });
  for (const int axis : axes) {
    const AxisView view = {(axis + 1) % 3, (axis + 2) % 3};
    if (SignOf(ring, view) != 0) return view;
  }
  return std::nullopt;
}

bool IsInside(const PointRing& ring, const Point3& position, AxisView view) {
  const Point2 p = view.Of(position);
  bool inside = false;
  ForEachEdgeOf(std::span(&ring, 1), [&](const Point3& from, const Point3& to) {
    inside ^= geometry::CrossesEdge(p, view.Of(from), view.Of(to)).value_or(false);
  });
  return inside;
}

std::optional<std::vector<int>> DepthsOf(const std::vector<PointRing>& rings, AxisView view) {
  std::vector<int> depths(rings.size(), 0);
  for (std::size_t i = 0; i < rings.size(); ++i) {
    for (std::size_t j = 0; j < rings.size(); ++j) {
      if (i == j) continue;
      const auto free = std::find_if(rings[i].begin(), rings[i].end(),
                                     [&](const Point3& p) { return !IsCorner(rings[j], p); });
      if (free == rings[i].end()) return std::nullopt;
      if (IsInside(rings[j], *free, view)) ++depths[i];
    }
  }
  return depths;
}

}  // namespace dynmesh::coplanar
