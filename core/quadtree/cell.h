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
    std::uint64_t code = 0;
    for (int k = 0; k < D; ++k) {
      code |= Spread(level <= kBits ? at[k] << (kBits - level) : at[k] >> (level - kBits)) << k;
    }
    return code;
  }
  // Child(which).Morton(), of a cell with this Morton() and level.
  static std::uint64_t MortonOfChild(std::uint64_t morton, int level, int which) {
    if (level >= kBits) return morton;
    return morton | static_cast<std::uint64_t>(which) << (D * (kBits - 1 - level));
  }
  std::uint64_t Hash() const {
    std::uint64_t h = Mix(static_cast<std::uint64_t>(level));
    for (int k = 0; k < D; ++k) h = Mix(h ^ at[k]);
    return h;
  }

 private:
  static constexpr int kBits = 64 / D;

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

// A cell's borders, and those between its children.
template <int D>
struct Halves {
  geometry::Point<D> lo{}, middle{}, hi{};

  Box<D> Child(int which) const {
    Box<D> child;
    for (int k = 0; k < D; ++k) {
      const bool is_upper = (which >> k & 1) != 0;
      child.lo[k] = is_upper ? middle[k] : lo[k];
      child.hi[k] = is_upper ? hi[k] : middle[k];
    }
    return child;
  }
  // Bit i: a box that meets the cell, from `from` to `to` along each axis, meets child i.
  std::uint32_t ChildrenMet(const geometry::Point<D>& from, const geometry::Point<D>& to) const {
    std::uint32_t met = kAll;
    for (int k = 0; k < D; ++k) {
      const auto axis = static_cast<std::size_t>(k);
      met &= (from[k] <= middle[k] ? kAll & ~kUpper[axis] : 0) |
             (to[k] >= middle[k] ? kUpper[axis] : 0);
    }
    return met;
  }

 private:
  static constexpr std::uint32_t kAll = (std::uint32_t{1} << Cell<D>::kChildren) - 1;
  // [k]: the children in the upper half along axis k.
  static constexpr std::array<std::uint32_t, D> kUpper = [] {
    std::array<std::uint32_t, D> upper = {};
    for (int i = 0; i < D << D; ++i) {
      const int k = i % D, which = i / D;
      if ((which >> k & 1) != 0) upper[static_cast<std::size_t>(k)] |= std::uint32_t{1} << which;
    }
    return upper;
  }();
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
      box.lo[k] = lo_[k] + ToDouble(cell.at[k]) * side;
      box.hi[k] = lo_[k] + ToDouble(cell.at[k] + 1) * side;
    }
    return box;
  }
  Halves<D> HalvesOf(const Cell<D>& cell) const {
    const Box<D> box = BoxOf(cell);
    return {box.lo, CentreOf(cell), box.hi};
  }
  // Exact: of a cell of most_level(), too.
  geometry::Point<D> CentreOf(const Cell<D>& cell) const {
    const double half = Side(cell.level + 1);
    geometry::Point<D> centre;
    for (int k = 0; k < D; ++k) {
      centre[k] = lo_[k] + ToDouble(2 * cell.at[k] + 1) * half;
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
      const double middle = lo_[k] + ToDouble(2 * cell.at[k] + 1) * half;
      which |= (p[k] < middle ? 0 : 1) << k;
    }
    return which;
  }

 private:
  // Of at most kMostLevel + 2 bits. Processors convert signed words in one step, others in several.
  static double ToDouble(std::uint64_t at) {
    return static_cast<double>(static_cast<std::int64_t>(at));
  }

  geometry::Point<D> lo_{};
  std::array<double, kMostLevel + 3> sides_{};  // by level; beyond the greatest, for halves
  int most_level_ = 0;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_CELL_H_
