// Cells of a quadtree (octree, ...): dyadic squares (cubes, ...) in a root cell.
//
// A cell is closed and has exact borders: doubles. Cells of one size that share a point *touch*.
// Values; pure functions, thread-safe, O(1).
#ifndef DYNMESH_CORE_QUADTREE_CELL_H_
#define DYNMESH_CORE_QUADTREE_CELL_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <utility>

#include "core/base/mix.h"
#include "core/geometry/point.h"

namespace dynmesh::quadtree {

// No cell is finer. Far below what validated features can cause: a fuse.
inline constexpr int kMostLevel = 48;

// Cell `at` of the 2^level along each axis; level 0 is the root.
template <int D>
struct Cell {
  int level = 0;
  std::array<std::uint64_t, D> at = {};

  friend bool operator==(const Cell&, const Cell&) = default;
  friend auto operator<=>(const Cell&, const Cell&) = default;

  static constexpr int kChildren = 1 << D;
  // Bit k of `which`: the upper half along axis k.
  Cell Child(int which) const {
    Cell child{level + 1, at};
    for (int k = 0; k < D; ++k) child.at[k] = at[k] << 1 | (which >> k & 1);
    return child;
  }
  // REQUIRES: not the root.
  Cell Parent() const {
    Cell parent{level - 1, at};
    for (int k = 0; k < D; ++k) parent.at[k] >>= 1;
    return parent;
  }
  // Which child of its parent it is.
  int Which() const {
    int which = 0;
    for (int k = 0; k < D; ++k) which |= static_cast<int>(at[k] & 1) << k;
    return which;
  }
  // Is `other`, of the same level or a finer one, in this cell?
  bool Contains(const Cell& other) const {
    if (other.level < level) return false;
    for (int k = 0; k < D; ++k) {
      if (other.at[k] >> (other.level - level) != at[k]) return false;
    }
    return true;
  }
  // Uniform: the priority of its operations.
  std::uint64_t Hash() const {
    std::uint64_t h = Mix(static_cast<std::uint64_t>(level));
    for (int k = 0; k < D; ++k) h = Mix(h ^ at[k]);
    return h;
  }
  template <class H>
  friend H AbslHashValue(H h, const Cell& cell) {
    return H::combine(std::move(h), cell.Hash());
  }
};

// Calls f(cell) for the cells of its level that touch it, itself included, within the root, until f
// returns false. Returns false if it did.
template <int D, class F>
bool ForEachTouching(const Cell<D>& cell, F f) {
  const std::uint64_t last = (std::uint64_t{1} << cell.level) - 1;
  Cell<D> other = cell;
  const auto visit = [&](auto& self, int axis) -> bool {
    if (axis == D) return f(other);
    const std::uint64_t x = cell.at[axis];
    for (std::uint64_t y = x == 0 ? 0 : x - 1; y <= (x == last ? x : x + 1); ++y) {
      other.at[axis] = y;
      if (!self(self, axis + 1)) return false;
    }
    return true;
  };
  return visit(visit, 0);
}

// Calls f(cell) for the cells of twice its side that touch it; one of them contains it. At most
// 2^D.
template <int D, class F>
void ForEachCoarserTouching(const Cell<D>& cell, F f) {
  if (cell.level == 0) return;
  const std::uint64_t last = (std::uint64_t{1} << (cell.level - 1)) - 1;
  Cell<D> other = cell.Parent();
  const auto visit = [&](auto& self, int axis) -> void {
    if (axis == D) return f(other);
    const std::uint64_t parent = cell.at[axis] >> 1;
    const bool is_upper = cell.at[axis] & 1;
    other.at[axis] = parent;
    self(self, axis + 1);
    if (is_upper ? parent == last : parent == 0) return;
    other.at[axis] = is_upper ? parent + 1 : parent - 1;
    self(self, axis + 1);
  };
  visit(visit, 0);
}

// A closed box.
template <int D>
struct Box {
  geometry::Point<D> lo{}, hi{};

  bool Holds(const geometry::Point<D>& p) const {
    for (int k = 0; k < D; ++k) {
      if (p[k] < lo[k] || p[k] > hi[k]) return false;
    }
    return true;
  }
  bool Meets(const Box& other) const {
    for (int k = 0; k < D; ++k) {
      if (other.hi[k] < lo[k] || other.lo[k] > hi[k]) return false;
    }
    return true;
  }
};

// Where the root lies.
template <int D>
class Grid {
 public:
  // The root is a cube around the box; its side is a power of two, about 8/7 to 16/7 of the box's
  // longest side (1, if that is 0). Its borders are multiples of an eighth of the side.
  Grid(const geometry::Point<D>& lo, const geometry::Point<D>& hi) {
    double extent = 0, magnitude = 0;
    for (int k = 0; k < D; ++k) {
      extent = std::max(extent, hi[k] - lo[k]);
      magnitude = std::max({magnitude, std::fabs(lo[k]), std::fabs(hi[k])});
    }
    if (!(extent > 0)) extent = 1;
    std::frexp(extent * (8.0 / 7), &exponent_);  // < 2^exponent
    const double unit = std::ldexp(1.0, exponent_ - 3);
    for (int k = 0; k < D; ++k) lo_[k] = std::floor(lo[k] / unit) * unit;
    // Borders are multiples of a cell's side, and below 2 (magnitude + side of the root).
    int most = 0;
    std::frexp(magnitude + Side(0), &most);
    most_level_ = std::min(kMostLevel, 52 - (most - exponent_));
  }

  // Cells of this level are not split.
  int most_level() const { return most_level_; }
  const geometry::Point<D>& lo() const { return lo_; }
  double Side(int level) const { return std::ldexp(1.0, exponent_ - level); }
  Box<D> BoxOf(const Cell<D>& cell) const {
    const double side = Side(cell.level);
    Box<D> box;
    for (int k = 0; k < D; ++k) {
      box.lo[k] = lo_[k] + static_cast<double>(cell.at[k]) * side;
      box.hi[k] = lo_[k] + static_cast<double>(cell.at[k] + 1) * side;
    }
    return box;
  }
  // The box of all cells of its size that touch it, in the root or not.
  Box<D> BlockOf(const Cell<D>& cell) const {
    Box<D> box = BoxOf(cell);
    const double side = Side(cell.level);
    for (int k = 0; k < D; ++k) box.lo[k] -= side, box.hi[k] += side;
    return box;
  }
  // The child of `cell` that p is in; on a border the upper one.
  int ChildAt(const Cell<D>& cell, const geometry::Point<D>& p) const {
    const double half = Side(cell.level + 1);
    int which = 0;
    for (int k = 0; k < D; ++k) {
      const double middle = lo_[k] + static_cast<double>(2 * cell.at[k] + 1) * half;
      which |= (p[k] < middle ? 0 : 1) << k;
    }
    return which;
  }

 private:
  geometry::Point<D> lo_{};
  int exponent_ = 0;  // of the root's side
  int most_level_ = 0;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_CELL_H_
