#include "core/plc/far_apart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/point.h"

namespace dynmesh::plc {
namespace {

// Points by columns of the box (2D: strips). Columns divide all axes but the last; in each column
// points are sorted by the last coordinate. Two close points are in the same column or in
// neighbouring ones.
template <int D>
class Columns {
 public:
  using Point = geometry::Point<D>;

  Columns(std::span<const PointFeature<D>> points, const Box& box, double limit, Steps& steps) {
    const double wanted = std::floor(std::pow(static_cast<double>(points.size()), 1.0 / D));
    std::array<double, D - 1> per_length;
    for (int k = 0; k < D - 1; ++k) {
      const double width = box.hi[k] - box.lo[k];
      const double count = std::clamp(std::floor(width / (4 * limit)), 1.0, std::max(wanted, 1.0));
      per_length[k] = width > 0 ? count / width : 0;  // a box may be a line
      counts_[k] = static_cast<int>(count);
    }
    const auto column_of = [&](const Point& p) {
      std::array<int, 2> at = {};
      for (int k = 0; k < D - 1; ++k) {
        const double last = counts_[k] - 1;
        at[k] = static_cast<int>(std::clamp((p[k] - box.lo[k]) * per_length[k], 0.0, last));
      }
      return IndexOf(at[0], at[1]);
    };
    begins_.assign(IndexOf(0, counts_[1]) + 1, 0);
    for (const PointFeature<D>& f : points) ++begins_[column_of(f.p) + 1];
    for (std::size_t c = 1; c < begins_.size(); ++c) begins_[c] += begins_[c - 1];
    std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
    points_.resize(points.size());
    for (const PointFeature<D>& f : points) points_[next[column_of(f.p)]++] = f.p;
    for (std::size_t c = 0; c + 1 < begins_.size(); ++c) {
      if (steps.Stop(begins_[c + 1] - begins_[c])) return;
      std::sort(points_.begin() + static_cast<std::ptrdiff_t>(begins_[c]),
                points_.begin() + static_cast<std::ptrdiff_t>(begins_[c + 1]),
                [](const Point& a, const Point& b) { return a[D - 1] < b[D - 1]; });
    }
  }
  const std::array<int, 2>& counts() const { return counts_; }
  // Columns outside are empty.
  std::span<const Point> At(int i, int j) const {
    if (i < 0 || i >= counts_[0] || j >= counts_[1]) return {};
    const std::size_t c = IndexOf(i, j);
    return std::span(points_).subspan(begins_[c], begins_[c + 1] - begins_[c]);
  }

 private:
  std::size_t IndexOf(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(counts_[0]) +
           static_cast<std::size_t>(i);
  }

  std::array<int, 2> counts_ = {1, 1};
  std::vector<std::size_t> begins_;
  std::vector<Point> points_;
};

}  // namespace

template <int D>
bool AreFarApart(std::span<const PointFeature<D>> points, const Box& box, double limit,
                 Steps& steps) {
  using Point = geometry::Point<D>;
  constexpr int kLast = D - 1;
  const Columns<D> columns(points, box, limit, steps);
  const double limit2 = limit * limit * kBarelyWider;
  std::size_t looks_left = 16 * points.size();
  // Compares p with the points of `others`, from `from` on, that are not above it by more than
  // limit.
  const auto is_far = [&](const Point& p, std::span<const Point> others, std::size_t from) {
    for (std::size_t i = from; i < others.size() && others[i][kLast] - p[kLast] <= limit; ++i) {
      if (looks_left-- == 0 || geometry::SquaredDistance(p, others[i]) <= limit2) return false;
    }
    return true;
  };
  for (int j = 0; j < columns.counts()[1]; ++j) {
    for (int i = 0; i < columns.counts()[0]; ++i) {
      const auto own = columns.At(i, j);
      // The neighbours that are compared with this column here.
      const std::array others = {columns.At(i + 1, j), columns.At(i - 1, j + 1),
                                 columns.At(i, j + 1), columns.At(i + 1, j + 1)};
      std::array<std::size_t, 4> first =
          {};  // per column: the first point not below p by more than limit
      for (std::size_t at = 0; at < own.size(); ++at) {
        if (steps.Stop()) return false;
        const Point& p = own[at];
        if (!is_far(p, own, at + 1)) return false;
        for (std::size_t k = 0; k < others.size(); ++k) {
          const std::span<const Point> other = others[k];
          while (first[k] < other.size() && p[kLast] - other[first[k]][kLast] > limit) ++first[k];
          if (!is_far(p, other, first[k])) return false;
        }
      }
    }
  }
  return true;
}

template bool AreFarApart<2>(std::span<const PointFeature<2>>, const Box&, double, Steps&);
template bool AreFarApart<3>(std::span<const PointFeature<3>>, const Box&, double, Steps&);

}  // namespace dynmesh::plc
