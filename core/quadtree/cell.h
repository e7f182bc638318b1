// Cells of a quadtree (octree, ...): dyadic squares (cubes, ...) in a root cell.
//
// A cell is closed and has exact borders: doubles. Cells of one size that share a point *touch*.
// Values; pure functions, thread-safe, O(1).
#ifndef DYNMESH_CORE_QUADTREE_CELL_H_
#define DYNMESH_CORE_QUADTREE_CELL_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <compare>
#include <cstdint>

#include "core/base/mix.h"
#include "core/base/root_cube.h"
#include "core/geometry/point.h"

namespace dynmesh::quadtree {

// No cell is finer. Validated features need far less; this bounds the work of all others.
inline constexpr int kMostLevel = 48;

// No index.
inline constexpr std::uint32_t kNone = ~std::uint32_t{0};

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
  // The first 64 / D bits along each axis, interleaved: its place on a Z-order curve.
  std::uint64_t Morton() const {
    constexpr int kBits = 64 / D;
    std::uint64_t code = 0;
    for (int k = 0; k < D; ++k) {
      code |= Spread(level <= kBits ? at[k] << (kBits - level) : at[k] >> (level - kBits)) << k;
    }
    return code;
  }
  std::uint64_t Hash() const {
    std::uint64_t h = Mix(static_cast<std::uint64_t>(level));
    for (int k = 0; k < D; ++k) h = Mix(h ^ at[k]);
    return h;
  }

 private:
  // Moves bit i of the lower 64 / D bits to bit D i: halves the groups of bits, again and again.
  static constexpr std::uint64_t Spread(std::uint64_t x) {
    for (int group = static_cast<int>(std::bit_ceil(64u / D)) / 2; group >= 1; group /= 2) {
      x = (x | x << (group * (D - 1))) & kGroups[std::countr_zero(static_cast<unsigned>(group))];
    }
    return x;
  }
  // [j]: groups of 2^j bits, D 2^j apart.
  static constexpr std::array<std::uint64_t, 5> kGroups = [] {
    std::array<std::uint64_t, 5> groups = {};
    for (int j = 0; j < 5; ++j) {
      for (int bit = 0; bit < 64 / D * D; ++bit) {
        const int group = 1 << j, within = bit % (D * group);
        if (within < group) groups[j] |= std::uint64_t{1} << bit;
      }
    }
    return groups;
  }();
};

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
  // The root is RootAround(lo, hi).
  Grid(const geometry::Point<D>& lo, const geometry::Point<D>& hi) {
    const RootCube<D> root = RootAround<D>(lo.c, hi.c);
    lo_.c = root.lo;
    for (std::size_t level = 0; level < sides_.size(); ++level) {
      sides_[level] = std::ldexp(1.0, root.exponent - static_cast<int>(level));
    }
    // Borders are multiples of a cell's side, and below 2^most in magnitude.
    double magnitude = 0;
    for (int k = 0; k < D; ++k) {
      magnitude = std::max({magnitude, std::fabs(lo_[k]), std::fabs(lo_[k] + Side(0))});
    }
    int most = 0;
    std::frexp(magnitude, &most);
    most_level_ = std::min(kMostLevel, 52 - (most - root.exponent));
  }

  // Cells of this level are not split.
  int most_level() const { return most_level_; }
  double Side(int level) const { return sides_[static_cast<std::size_t>(level)]; }
  Box<D> BoxOf(const Cell<D>& cell) const {
    const double side = Side(cell.level);
    Box<D> box;
    for (int k = 0; k < D; ++k) {
      box.lo[k] = lo_[k] + static_cast<double>(cell.at[k]) * side;
      box.hi[k] = lo_[k] + static_cast<double>(cell.at[k] + 1) * side;
    }
    return box;
  }
  // Exact: of a cell of most_level(), too.
  geometry::Point<D> CentreOf(const Cell<D>& cell) const {
    const double half = Side(cell.level + 1);
    geometry::Point<D> centre;
    for (int k = 0; k < D; ++k) {
      centre[k] = lo_[k] + static_cast<double>(2 * cell.at[k] + 1) * half;
    }
    return centre;
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
  std::array<double, kMostLevel + 3> sides_{};  // by level; beyond the greatest, for halves
  int most_level_ = 0;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_CELL_H_
