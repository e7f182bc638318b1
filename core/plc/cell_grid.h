// Dyadic cells over the user's box, and segments as seen by them.
//
// The unit of length is 1/16 of the distance below which features are too close, a
// power of two. A cell is a square of 2^k units at integer multiples of its side.
// A coordinate is *quantised* (rounded down to a whole number of units) by monotone
// roundings, so that "left of cell c" is exact and means the same to everyone; real
// positions in units are doubles with an error below 1/16. Pure, thread-safe, O(1).
#ifndef DYNMESH_CORE_PLC_CELL_GRID_H_
#define DYNMESH_CORE_PLC_CELL_GRID_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/geometry/point.h"
#include "core/plc/delta.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Close features lie less than this many units apart.
inline constexpr double kCloseUnits = 16;

// A position in units.
using UnitPoint = std::array<double, 2>;

// The square [x, x + side) x [y, y + side), in units; side is a power of two.
struct Cell {
  std::array<std::int64_t, 2> at{};
  std::int64_t side = 1;

  Cell Child(int quadrant) const {
    const std::int64_t half = side / 2;
    return {{at[0] + (quadrant & 1) * half, at[1] + (quadrant >> 1) * half}, half};
  }
  double Lo(int axis) const { return static_cast<double>(at[axis]); }
  double Hi(int axis) const { return static_cast<double>(at[axis] + side); }
};

class CellGrid {
 public:
  // `limit` is CloseLimit of the mesh whose features lie in `box`.
  CellGrid(const Box& box, double limit)
      : origin_{box.lo[0], box.lo[1]}, per_length_(kCloseUnits / limit) {
    const double extent = std::max(box.hi[0] - box.lo[0], box.hi[1] - box.lo[1]);
    while (static_cast<double>(root_.side) <= extent * per_length_) root_.side *= 2;
  }

  // Holds every point of the box.
  const Cell& root() const { return root_; }

  double LengthOf(double units) const { return units / per_length_; }
  UnitPoint ToUnits(const geometry::Point2& p) const {
    return {(p[0] - origin_[0]) * per_length_, (p[1] - origin_[1]) * per_length_};
  }
  static std::int64_t Quantise(double units) {
    return static_cast<std::int64_t>(std::floor(units));
  }

 private:
  std::array<double, 2> origin_;
  double per_length_;  // units per length, a power of two
  Cell root_;
};

// A segment in units. It is *flat* if |dy| <= |dx|, else *steep*; its major axis is x
// if flat, else y; lo and hi are its ends by the coordinate of the major axis.
struct GridSegment {
  SegmentFeature<2> feature;
  bool flat = true;
  bool reversed = false;  // lo is feature.q
  UnitPoint lo{};
  UnitPoint hi{};

  GridSegment() = default;
  GridSegment(const SegmentFeature<2>& f, const CellGrid& grid);

  int major() const { return flat ? 0 : 1; }
  const geometry::Point2& lo_point() const { return reversed ? feature.q : feature.p; }
  const geometry::Point2& hi_point() const { return reversed ? feature.p : feature.q; }

  // Does it cover, on its major axis, every coordinate that quantises into `cell`?
  bool Spans(const Cell& cell) const {
    const int axis = major();
    return CellGrid::Quantise(lo[axis]) < cell.at[axis] &&
           CellGrid::Quantise(hi[axis]) >= cell.at[axis] + cell.side;
  }
  // Does it meet the closed `cell` grown by `reach` >= 1/4 to every side? May say yes
  // if it misses by a fraction of a unit, never no if it meets.
  bool Meets(const Cell& cell, double reach) const;

  // The minor coordinate of its line where the major one is `major_at`.
  double MinorAt(double major_at) const {
    const int a = major(), b = 1 - a;
    return lo[b] + (hi[b] - lo[b]) * ((major_at - lo[a]) / (hi[a] - lo[a]));
  }
};

inline GridSegment::GridSegment(const SegmentFeature<2>& f, const CellGrid& grid)
    : feature(f), lo(grid.ToUnits(f.p)), hi(grid.ToUnits(f.q)) {
  flat = std::abs(hi[1] - lo[1]) <= std::abs(hi[0] - lo[0]);
  reversed = hi[major()] < lo[major()];
  if (reversed) std::swap(lo, hi);
}

inline bool GridSegment::Meets(const Cell& cell, double reach) const {
  const double half = static_cast<double>(cell.side) / 2 + reach;
  const double cx = cell.Lo(0) + static_cast<double>(cell.side) / 2 - lo[0];
  const double cy = cell.Lo(1) + static_cast<double>(cell.side) / 2 - lo[1];
  const double dx = hi[0] - lo[0], dy = hi[1] - lo[1];
  // Separating axes: x, y, and the normal of the segment.
  if (cx + half < std::min(0.0, dx) || cx - half > std::max(0.0, dx)) return false;
  if (cy + half < std::min(0.0, dy) || cy - half > std::max(0.0, dy)) return false;
  return std::abs(dx * cy - dy * cx) <= (std::abs(dx) + std::abs(dy)) * half;
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_CELL_GRID_H_
