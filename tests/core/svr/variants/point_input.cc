#include "tests/core/svr/variants/point_input.h"

#include <array>
#include <numeric>
#include <utility>

#include "core/geometry/border_grid.h"

namespace dynmesh::svr {
namespace {

using geometry::Point;
using geometry::Point2;
using geometry::Point3;

// The corners first, in the order of the triangulation.
std::vector<Point2> BorderOf(const Options<2>& options) {
  const int cells = options.border_cells;
  std::vector<Point2> border = geometry::SquareBorder(options.lo, options.hi, cells,
                                                      (options.hi[0] - options.lo[0]) / cells);
  for (int i = 0; i < 4; ++i) std::swap(border[i], border[i * cells]);
  return border;
}
// In any dimension: the corners by their bits, then all others.
template <int D>
std::vector<Point<D>> BorderOf(const Options<D>& options) {
  const int cells = options.border_cells;
  std::vector<Point<D>> border, others;
  std::array<int, D> at = {};
  // Counts from (0, ..., 0) to (cells, ..., cells), the first axis fastest: corners by their bits.
  for (int k = 0; k < D;) {
    int sides = 0;
    Point<D> p;
    for (int axis = 0; axis < D; ++axis) {
      sides += at[axis] % cells == 0 ? 1 : 0;
      p[axis] = at[axis] == cells
                    ? options.hi[axis]
                    : options.lo[axis] + at[axis] * ((options.hi[axis] - options.lo[axis]) / cells);
    }
    if (sides == D) border.push_back(p);
    if (sides > 0 && sides < D) others.push_back(p);
    for (k = 0; k < D && ++at[k] > cells; ++k) at[k] = 0;
  }
  border.insert(border.end(), others.begin(), others.end());
  return border;
}
std::vector<Point3> BorderOf(const Options<3>& options) {
  return geometry::CubeBorder(options.lo, options.hi, options.border_cells,
                              (options.hi[0] - options.lo[0]) / options.border_cells);
}

}  // namespace

template <int D>
PointInput<D>::PointInput(const Options<D>& options, std::vector<Point> points)
    : positions_(BorderOf(options)), border_count_(positions_.size()) {
  for (const VertexIndex i : HilbertOrder(points, options)) positions_.push_back(points[i]);
  end_ = static_cast<VertexIndex>(positions_.size());
}

template <int D>
std::vector<VertexIndex> PointInput<D>::Waiting() const {
  std::vector<VertexIndex> all(positions_.size() - border_count_);
  std::iota(all.begin(), all.end(), static_cast<VertexIndex>(border_count_));
  return all;
}

template class PointInput<2>;
template class PointInput<3>;
template class PointInput<4>;

}  // namespace dynmesh::svr
