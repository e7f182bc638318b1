// Dyadic cells over the user's box, and segments in the units of cells, in 2D and 3D.
//
// The unit of length is 1/16 of the distance below which features are too close, a power of two. A
// cell is a square or cube of 2^k units at integer multiples of its side. Coordinates are
// *quantised* (rounded down to a whole number of units) by monotone roundings, so "left of cell c"
// is exact and consistent. Real positions in units are doubles with an error below 1/16. Pure,
// thread-safe, O(1).
#ifndef DYNMESH_CORE_PLC_CELL_GRID_H_
#define DYNMESH_CORE_PLC_CELL_GRID_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/large_vector.h"
#include "core/geometry/point.h"
#include "core/plc/delta.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Close features are less than this many units apart.
inline constexpr double kCloseUnits = 16;

// Index of a feature in a table of its index.
using Slot = std::uint32_t;

// A position in units.
template <int D>
using UnitPoint = std::array<double, D>;

// The square [x, x + side) x [y, y + side), or cube, in units; side is a power of two.
template <int D>
struct Cell {
  static constexpr int kChildren = 1 << D;

  std::array<std::int64_t, D> at{};
  std::int64_t side = 1;

  // Bit i of `which`: the upper half of axis i.
  Cell Child(int which) const {
    Cell child = {at, side / 2};
    for (int i = 0; i < D; ++i) child.at[i] += ((which >> i) & 1) * child.side;
    return child;
  }
  double Lo(int axis) const { return static_cast<double>(at[axis]); }
  double Hi(int axis) const { return static_cast<double>(at[axis] + side); }

  // Calls visit(i) for the children that meet the box of a and b grown by `reach`. Conservative:
  // may visit a child that misses it by a unit.
  template <class Visit>
  void ForChildrenNear(const UnitPoint<D>& a, const UnitPoint<D>& b, double reach,
                       Visit visit) const {
    int below = 0, above = 0;  // a bit per axis: does the box meet the lower, the upper half?
    for (int i = 0; i < D; ++i) {
      const double middle = static_cast<double>(at[i] + side / 2);
      below |= (std::min(a[i], b[i]) - reach - 1 <= middle ? 1 : 0) << i;
      above |= (std::max(a[i], b[i]) + reach + 1 >= middle ? 1 : 0) << i;
    }
    for (int i = 0; i < kChildren; ++i) {
      if ((i & ~above) == 0 && (~i & ~below & (kChildren - 1)) == 0) visit(i);
    }
  }
};

template <int D>
class CellGrid {
 public:
  // `limit` is CloseLimit of the mesh, `box` its box.
  CellGrid(const Box& box, double limit) : per_length_(kCloseUnits / limit) {
    double extent = 0;
    for (int i = 0; i < D; ++i) {
      origin_[i] = box.lo[i];
      extent = std::max(extent, box.hi[i] - box.lo[i]);
    }
    while (static_cast<double>(root_.side) <= extent * per_length_) root_.side *= 2;
  }

  // Holds every point of the box.
  const Cell<D>& root() const { return root_; }

  double LengthOf(double units) const { return units / per_length_; }
  double UnitsOf(double length) const { return length * per_length_; }
  UnitPoint<D> ToUnits(const geometry::Point<D>& p) const {
    UnitPoint<D> units;
    for (int i = 0; i < D; ++i) units[i] = (p[i] - origin_[i]) * per_length_;
    return units;
  }
  static std::int64_t Quantise(double units) {
    return static_cast<std::int64_t>(std::floor(units));
  }

 private:
  std::array<double, D> origin_;
  double per_length_;  // units per length, a power of two
  Cell<D> root_;
};

// A segment in units. In 2D it is *flat* if |dy| <= |dx|, else *steep*. Its major axis is x if
// flat, else y; lo and hi are its ends by the major coordinate.
template <int D>
struct GridSegment {
  SegmentFeature<D> feature;
  bool flat = true;
  bool reversed = false;  // lo is feature.q
  UnitPoint<D> lo{};
  UnitPoint<D> hi{};

  GridSegment() = default;
  GridSegment(const SegmentFeature<D>& f, const CellGrid<D>& grid)
      : feature(f), lo(grid.ToUnits(f.p)), hi(grid.ToUnits(f.q)) {
    if constexpr (D == 2) {
      flat = std::abs(hi[1] - lo[1]) <= std::abs(hi[0] - lo[0]);
      reversed = hi[major()] < lo[major()];
      if (reversed) std::swap(lo, hi);
    }
  }

  int major() const { return flat ? 0 : 1; }
  const geometry::Point<D>& lo_point() const { return reversed ? feature.q : feature.p; }
  const geometry::Point<D>& hi_point() const { return reversed ? feature.p : feature.q; }

  // The longest side of its box.
  double Extent() const {
    double extent = 0;
    for (int i = 0; i < D; ++i) extent = std::max(extent, std::abs(hi[i] - lo[i]));
    return extent;
  }
  // Does it cover, on its major axis, every coordinate that quantises into `cell`?
  bool Spans(const Cell<2>& cell) const {
    const int axis = major();
    return CellGrid<D>::Quantise(lo[axis]) < cell.at[axis] &&
           CellGrid<D>::Quantise(hi[axis]) >= cell.at[axis] + cell.side;
  }
  // Does it meet the closed `cell` grown by `reach` >= 1/4 on every side? Conservative: may return
  // true needlessly (if it misses by a fraction of a unit), never false wrongly.
  bool Meets(const Cell<D>& cell, double reach) const;

  // Calls visit(i) for the children of `cell` that it may meet.
  template <class Visit>
  void ForChildrenNear(const Cell<D>& cell, double reach, Visit visit) const {
    cell.ForChildrenNear(lo, hi, reach, visit);
  }

  // The minor coordinate of its line at the major coordinate `major_at`.
  double MinorAt(double major_at) const {
    const int a = major(), b = 1 - a;
    return lo[b] + (hi[b] - lo[b]) * ((major_at - lo[a]) / (hi[a] - lo[a]));
  }
};

template <int D>
using SegmentTable = LargeVector<GridSegment<D>>;

template <int D>
inline bool GridSegment<D>::Meets(const Cell<D>& cell, double reach) const {
  const double half = static_cast<double>(cell.side) / 2 + reach;
  UnitPoint<D> c, d;  // from lo: the cell's centre, hi
  // Separating axes: the coordinate axes, and those normal to the segment and one of these.
  for (int i = 0; i < D; ++i) {
    c[i] = cell.Lo(i) + static_cast<double>(cell.side) / 2 - lo[i];
    d[i] = hi[i] - lo[i];
    if (c[i] + half < std::min(0.0, d[i]) || c[i] - half > std::max(0.0, d[i])) return false;
  }
  for (int i = 0; i < D; ++i) {
    for (int j = i + 1; j < D; ++j) {
      if (std::abs(d[i] * c[j] - d[j] * c[i]) > (std::abs(d[i]) + std::abs(d[j])) * half) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_CELL_GRID_H_
