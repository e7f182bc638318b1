// The grid of points on the border of a square or cube, with which meshes begin. Pure functions.
#ifndef DYNMESH_CORE_GEOMETRY_BORDER_GRID_H_
#define DYNMESH_CORE_GEOMETRY_BORDER_GRID_H_

#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::geometry {

// Counter-clockwise from lo, 4 cells points; corner i is number i cells. `step`: the side of a
// cell, (hi - lo) / cells up to rounding.
inline std::vector<Point2> SquareBorder(const Point2& lo, const Point2& hi, int cells,
                                        double step) {
  const auto along = [&](int axis, int i) { return i == 0 ? lo[axis] : lo[axis] + i * step; };
  const auto back = [&](int axis, int i) {
    return i == 0 ? hi[axis] : lo[axis] + (cells - i) * step;
  };
  std::vector<Point2> border;
  for (int i = 0; i < cells; ++i) border.push_back({{along(0, i), lo[1]}});
  for (int i = 0; i < cells; ++i) border.push_back({{hi[0], along(1, i)}});
  for (int i = 0; i < cells; ++i) border.push_back({{back(0, i), hi[1]}});
  for (int i = 0; i < cells; ++i) border.push_back({{lo[0], back(1, i)}});
  return border;
}

// The corners first, bit k of their number: the upper end along axis k; then all others.
inline std::vector<Point3> CubeBorder(const Point3& lo, const Point3& hi, int cells, double step) {
  const auto at = [&](int axis, int i) { return i == cells ? hi[axis] : lo[axis] + i * step; };
  std::vector<Point3> border;
  const auto add = [&](int i, int j, int k) { border.push_back({{at(0, i), at(1, j), at(2, k)}}); };
  for (int m = 0; m < 8; ++m) add(m & 1 ? cells : 0, m & 2 ? cells : 0, m & 4 ? cells : 0);
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      for (int k = 0; k <= cells; ++k) {
        const int sides = (i % cells == 0) + (j % cells == 0) + (k % cells == 0);
        if (sides == 1 || sides == 2) add(i, j, k);
      }
    }
  }
  return border;
}

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_BORDER_GRID_H_
