// Which boxes may meet one of some others: a grid of cells, and sums over them. Conservative.
// Thread-compatible; const members may run concurrently.
#ifndef DYNMESH_CORE_PLC_MARKED_CELLS_H_
#define DYNMESH_CORE_PLC_MARKED_CELLS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::plc {

class MarkedCells {
 public:
  // About as many cells as there are `things`, over the box from `lo` to `hi`.
  MarkedCells(const geometry::Point3& lo, const geometry::Point3& hi, std::size_t things)
      : lo_(lo),
        side_(std::clamp<std::size_t>(
            static_cast<std::size_t>(std::cbrt(static_cast<double>(things))), 1, 64)),
        sums_((side_ + 1) * (side_ + 1) * (side_ + 1), 0) {
    for (int k = 0; k < 3; ++k) {
      const double extent = hi[k] - lo[k];
      scale_[k] = extent > 0 ? static_cast<double>(side_) / extent : 0;
    }
  }

  // Marks the cells of a box, grown by a share of a cell. Before the first question.
  void Mark(const geometry::Point3& lo, const geometry::Point3& hi) {
    const auto [from, to] = CellsOf(lo, hi);
    for (int which = 0; which < 8; ++which) {
      const auto pick = [&](int k) { return (which >> k) & 1 ? to[k] : from[k]; };
      const int sign = ((which >> 0) ^ (which >> 1) ^ (which >> 2)) & 1 ? -1 : 1;
      At(pick(0), pick(1), pick(2)) += sign;
    }
  }
  // Ends marking. O(cells).
  void Finish() {
    // From differences to marks, to sums of marks before a cell.
    Sum();
    for (std::int32_t& count : sums_) count = count > 0 ? 1 : 0;
    Sum();
    // sums_ has the sum up to a cell, itself included.
  }

  bool Meets(const geometry::Point3& lo, const geometry::Point3& hi) const {
    const auto [from, to] = CellsOf(lo, hi);
    std::int64_t sum = 0;
    for (int which = 0; which < 8; ++which) {
      bool is_empty = false;
      std::array<std::size_t, 3> at{};
      for (int k = 0; k < 3; ++k) {
        const bool upper = ((which >> k) & 1) != 0;
        if (!upper && from[k] == 0) is_empty = true;
        at[k] = upper ? to[k] - 1 : from[k] - 1;
      }
      if (is_empty) continue;
      const int lowers = 3 - ((which & 1) + ((which >> 1) & 1) + ((which >> 2) & 1));
      sum += (lowers % 2 == 0 ? 1 : -1) * std::int64_t{sums_[Index(at[0], at[1], at[2])]};
    }
    return sum > 0;
  }

 private:
  using Indices = std::array<std::size_t, 3>;

  std::size_t Index(std::size_t x, std::size_t y, std::size_t z) const {
    return (x * (side_ + 1) + y) * (side_ + 1) + z;
  }
  std::int32_t& At(std::size_t x, std::size_t y, std::size_t z) { return sums_[Index(x, y, z)]; }

  // The first cells, and those behind the last ones.
  std::array<Indices, 2> CellsOf(const geometry::Point3& lo, const geometry::Point3& hi) const {
    constexpr double kMore = 0.01;  // of a cell: far more than what is too close, or not flat
    std::array<Indices, 2> cells{};
    const auto most = static_cast<double>(side_ - 1);
    for (int k = 0; k < 3; ++k) {
      const double from = (lo[k] - lo_[k]) * scale_[k] - kMore;
      const double to = (hi[k] - lo_[k]) * scale_[k] + kMore;
      cells[0][k] = static_cast<std::size_t>(std::clamp(std::floor(from), 0.0, most));
      cells[1][k] = static_cast<std::size_t>(std::clamp(std::floor(to), 0.0, most)) + 1;
    }
    return cells;
  }

  void Sum() {
    for (std::size_t x = 0; x <= side_; ++x) {
      for (std::size_t y = 0; y <= side_; ++y) {
        for (std::size_t z = 0; z <= side_; ++z) {
          if (x > 0) At(x, y, z) += At(x - 1, y, z);
        }
      }
    }
    for (std::size_t x = 0; x <= side_; ++x) {
      for (std::size_t y = 1; y <= side_; ++y) {
        for (std::size_t z = 0; z <= side_; ++z) At(x, y, z) += At(x, y - 1, z);
      }
    }
    for (std::size_t x = 0; x <= side_; ++x) {
      for (std::size_t y = 0; y <= side_; ++y) {
        for (std::size_t z = 1; z <= side_; ++z) At(x, y, z) += At(x, y, z - 1);
      }
    }
  }

  const geometry::Point3 lo_;
  const std::size_t side_;
  std::array<double, 3> scale_{};
  std::vector<std::int32_t> sums_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_MARKED_CELLS_H_
