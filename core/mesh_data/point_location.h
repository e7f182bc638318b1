// Which simplices contain which of some points: exact, for many points at once.
#ifndef DYNMESH_CORE_MESH_DATA_POINT_LOCATION_H_
#define DYNMESH_CORE_MESH_DATA_POINT_LOCATION_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "core/geometry/predicates.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::mesh_data {

// Is p in the closed, positively oriented simplex? Exact.
inline bool IsIn(const std::array<geometry::Point2, 3>& s, const geometry::Point2& p) {
  return geometry::Orientation(s[0], s[1], p) >= 0 && geometry::Orientation(s[1], s[2], p) >= 0 &&
         geometry::Orientation(s[2], s[0], p) >= 0;
}
inline bool IsIn(const std::array<geometry::Point3, 4>& s, const geometry::Point3& p) {
  return geometry::Orientation(p, s[1], s[2], s[3]) >= 0 &&
         geometry::Orientation(s[0], p, s[2], s[3]) >= 0 &&
         geometry::Orientation(s[0], s[1], p, s[3]) >= 0 &&
         geometry::Orientation(s[0], s[1], s[2], p) >= 0;
}

// Calls found(row, i) for each simplex `row` below `rows` and each i such that the simplex contains
// points[i]. corners_of(row) returns its corners. O((rows + pairs of common x) lg points).
template <int D, class CornersOf, class Found>
void ForEachContaining(std::size_t rows, CornersOf corners_of,
                       std::span<const geometry::Point<D>> points, Found found) {
  using geometry::Point;
  std::vector<std::size_t> by_x(points.size());
  std::iota(by_x.begin(), by_x.end(), std::size_t{0});
  std::sort(by_x.begin(), by_x.end(),
            [&](std::size_t i, std::size_t j) { return points[i] < points[j]; });
  for (std::size_t row = 0; row < rows; ++row) {
    const std::array<Point<D>, D + 1> corners = corners_of(row);
    Point<D> lo = corners[0], hi = corners[0];
    for (const Point<D>& corner : corners) {
      for (std::size_t k = 0; k < D; ++k) {
        lo.c[k] = std::min(lo.c[k], corner.c[k]), hi.c[k] = std::max(hi.c[k], corner.c[k]);
      }
    }
    auto it = std::lower_bound(by_x.begin(), by_x.end(), lo.c[0],
                               [&](std::size_t i, double x) { return points[i].c[0] < x; });
    for (; it != by_x.end() && points[*it].c[0] <= hi.c[0]; ++it) {
      const Point<D>& p = points[*it];
      bool is_near = true;
      for (std::size_t k = 1; k < D; ++k) is_near &= lo.c[k] <= p.c[k] && p.c[k] <= hi.c[k];
      if (is_near && IsIn(corners, p)) found(row, *it);
    }
  }
}

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_POINT_LOCATION_H_
