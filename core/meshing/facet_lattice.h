// The lattices of facet anchors (facet_anchors.h): squares. Each *level* adds the centres of the
// squares of the level before. So spacings shrink by sqrt 2 from level to level, and each lattice
// contains all coarser ones. A point can be decided by itself: it belongs to the coarsest level
// that contains it, and a finer neighbourhood does not remove it.
//
// The lattice coordinates are those other than the normal's largest, with steps that are powers of
// two. So on facets one above the other, points lie one above the other. Measured in the facet,
// spacings are up to sqrt 3 times as wide. Pure; thread-safe.
#ifndef DYNMESH_CORE_MESHING_FACET_LATTICE_H_
#define DYNMESH_CORE_MESHING_FACET_LATTICE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/base/rounding.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"

namespace dynmesh::meshing {

class FacetLattice {
 public:
  using Point = geometry::Point3;

  // A point, identified by the coarsest level that contains it.
  struct Index {
    int level = 0;
    std::int64_t i = 0, j = 0;  // in steps of 2^-ceil(level / 2)

    friend bool operator==(const Index&, const Index&) = default;
    template <class H>
    friend H AbslHashValue(H h, const Index& index) {
      return H::combine(std::move(h), index.level, index.i, index.j);
    }
  };
  // A square, `side` = 2^-depth wide.
  struct Cell {
    int depth = 0;
    std::int64_t i = 0, j = 0;

    double side() const { return std::ldexp(1.0, -depth); }
  };

  explicit FacetLattice(const geometry::FacetPlane& plane)
      : plane_(plane), widening_(1 / plane.normal[static_cast<std::size_t>(plane.axis)]) {}

  // The widest spacing of a level along the facet. Uses no logarithm, hence no libm.
  double Spacing(int level) const {
    const double step = (level & 1) != 0 ? 1.4142135623730951 : 1;
    return widening_ * std::ldexp(step, -((level + 1) >> 1));
  }
  // The coarsest level with spacing <= `spacing`.
  int LevelOf(double spacing) const {
    const int level = -2 * std::ilogb(spacing / widening_);
    return Spacing(level - 1) <= spacing ? level - 1 : level;
  }

  Point MiddleOf(const Cell& cell) const {
    const double side = cell.side();
    return Lift((static_cast<double>(cell.i) + 0.5) * side,
                (static_cast<double>(cell.j) + 0.5) * side);
  }
  // An upper bound of the distance from the cell's middle to a point of the cell on the facet.
  double RadiusOf(const Cell& cell) const {
    return widening_ * 0.70711 * cell.side() * kBarelyWider;
  }
  static Cell Child(const Cell& cell, int quadrant) {
    return {cell.depth + 1, 2 * cell.i + (quadrant & 1), 2 * cell.j + (quadrant >> 1)};
  }
  // Calls f(cell) for at most four cells that cover the box from lo to hi, until f returns false.
  // Returns false if it did.
  template <class F>
  bool ForEachCellOver(const Point& lo, const Point& hi, F f) const {
    const std::size_t u = U(), v = V();
    const double widest = std::max(hi[u] - lo[u], hi[v] - lo[v]);
    const int depth = -1 - std::ilogb(widest);
    const double side = std::ldexp(1.0, -depth);
    const auto at = [side](double x) { return static_cast<std::int64_t>(std::floor(x / side)); };
    for (std::int64_t i = at(lo[u]); i <= at(hi[u]); ++i) {
      for (std::int64_t j = at(lo[v]); j <= at(hi[v]); ++j) {
        if (!f(Cell{depth, i, j})) return false;
      }
    }
    return true;
  }
  // Calls f(index, point) for the points of levels up to `finest` in the cell, without its upper
  // sides, until f returns false. Returns false if it did.
  template <class F>
  bool ForEachIn(const Cell& cell, int finest, F f) const {
    const int steps = (finest + 1) >> 1;  // the step is 2^-steps
    if (steps < cell.depth) return ForCorner(cell, finest, f);
    const std::int64_t count = std::int64_t{1} << (steps - cell.depth);
    for (std::int64_t i = cell.i * count; i < (cell.i + 1) * count; ++i) {
      for (std::int64_t j = cell.j * count; j < (cell.j + 1) * count; ++j) {
        if ((finest & 1) != 0 && ((i ^ j) & 1) != 0) continue;
        if (!f(Coarsest(steps, i, j), At(steps, i, j))) return false;
      }
    }
    return true;
  }

 private:
  static constexpr int kCoarsest = -64;

  std::size_t U() const { return static_cast<std::size_t>((plane_.axis + 1) % 3); }
  std::size_t V() const { return static_cast<std::size_t>((plane_.axis + 2) % 3); }

  Point At(int steps, std::int64_t i, std::int64_t j) const {
    return Lift(std::ldexp(static_cast<double>(i), -steps),
                std::ldexp(static_cast<double>(j), -steps));
  }
  // The point of the plane with coordinates (u, v), projected along the axis.
  Point Lift(double u, double v) const {
    const std::size_t a = static_cast<std::size_t>(plane_.axis);
    Point p;
    p[U()] = u;
    p[V()] = v;
    const double slope = plane_.normal[U()] * (u - plane_.origin[U()]) +
                         plane_.normal[V()] * (v - plane_.origin[V()]);
    p[a] = plane_.origin[a] - slope * widening_;
    return p;
  }
  static Index Coarsest(int steps, std::int64_t i, std::int64_t j) {
    while (((i | j) & 1) == 0 && steps > kCoarsest) i /= 2, j /= 2, --steps;
    const bool is_middle = (i & j & 1) != 0;
    return {2 * steps - (is_middle ? 1 : 0), i, j};
  }
  // For a cell narrower than the lattice's squares: its lowest corner, if that is a point.
  template <class F>
  bool ForCorner(const Cell& cell, int finest, F f) const {
    const Index index = Coarsest(cell.depth, cell.i, cell.j);
    return index.level > finest || f(index, At(cell.depth, cell.i, cell.j));
  }

  geometry::FacetPlane plane_;
  double widening_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FACET_LATTICE_H_
