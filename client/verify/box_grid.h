// Which boxes are near a box: a uniform grid over a mesh's vertices.
#ifndef DYNMESH_CLIENT_VERIFY_BOX_GRID_H_
#define DYNMESH_CLIENT_VERIFY_BOX_GRID_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::cli {

using GridPoint = std::array<double, 3>;

// A grid of some n cells; items in each cell that their boxes meet.
class BoxGrid {
 public:
  BoxGrid(const io::IndexedMesh& mesh, std::size_t cells)
      : d_(static_cast<std::size_t>(mesh.dimension)) {
    lo_.fill(HUGE_VAL);
    GridPoint hi;
    hi.fill(-HUGE_VAL);
    for (const auto& v : mesh.vertices) {
      for (std::size_t k = 0; k < d_; ++k) {
        lo_[k] = std::min(lo_[k], v.position()[k]), hi[k] = std::max(hi[k], v.position()[k]);
      }
    }
    const double wanted = std::pow(static_cast<double>(cells) + 1, 1.0 / static_cast<double>(d_));
    count_ = static_cast<std::size_t>(std::clamp(wanted, 1.0, 512.0));
    for (std::size_t k = 0; k < d_; ++k) {
      half_step_[k] = std::max((hi[k] / 2 - lo_[k] / 2) / static_cast<double>(count_), 1e-300);
    }
    items_.resize(d_ == 2 ? count_ * count_ : count_ * count_ * count_);
  }

  void Add(std::uint32_t item, const GridPoint& lo, const GridPoint& hi) {
    ForEachCell(lo, hi, [&](std::vector<std::uint32_t>& cell) { cell.push_back(item); });
  }
  // Calls f(item) for the items of cells that the box meets, some several times.
  template <class F>
  void ForEach(const GridPoint& lo, const GridPoint& hi, F f) {
    ForEachCell(lo, hi, [&](const std::vector<std::uint32_t>& cell) {
      for (const std::uint32_t item : cell) f(item);
    });
  }

 private:
  std::size_t CellOf(double c, std::size_t k) const {
    const double at = (c / 2 - lo_[k] / 2) / half_step_[k];  // the difference may be infinite
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count_ - 1)));
  }
  template <class F>
  void ForEachCell(const GridPoint& lo, const GridPoint& hi, F f) {
    std::array<std::size_t, 3> a = {0, 0, 0}, b = {0, 0, 0};
    for (std::size_t k = 0; k < d_; ++k) a[k] = CellOf(lo[k], k), b[k] = CellOf(hi[k], k);
    for (std::size_t z = a[2]; z <= b[2]; ++z) {
      for (std::size_t y = a[1]; y <= b[1]; ++y) {
        for (std::size_t x = a[0]; x <= b[0]; ++x) f(items_[(z * count_ + y) * count_ + x]);
      }
    }
  }

  const std::size_t d_;
  GridPoint lo_, half_step_ = {1, 1, 1};
  std::size_t count_ = 1;
  std::vector<std::vector<std::uint32_t>> items_;
};

// The corners of the simplex's bounding box.
template <std::size_t N>
std::pair<GridPoint, GridPoint> BoxOf(const io::IndexedMesh& mesh,
                                      const std::array<std::uint32_t, N>& corners) {
  GridPoint lo = mesh.vertices[corners[0]].position(), hi = lo;
  for (const std::uint32_t v : corners) {
    const GridPoint p = mesh.vertices[v].position();
    for (std::size_t k = 0; k < 3; ++k)
      lo[k] = std::min(lo[k], p[k]), hi[k] = std::max(hi[k], p[k]);
  }
  return {lo, hi};
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_BOX_GRID_H_
