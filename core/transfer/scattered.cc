#include "core/transfer/scattered.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <vector>

#include "core/delaunay/triangulation_of.h"
#include "core/geometry/point.h"
#include "core/transfer/simplex.h"

namespace dynmesh::transfer {
namespace {

using geometry::Point;

template <int D>
class ScatteredValues {
 public:
  ScatteredValues(std::span<const double> sources, std::span<const double> values)
      : count_(sources.size() / D),
        width_(values.size() / count_),
        values_(values.begin(), values.end()) {
    for (std::size_t i = 0; i < count_; ++i) points_.push_back(PointAt(sources, i));
  }

  std::vector<double> At(std::span<const double> targets) {
    std::vector<Point<D>> at;
    for (std::size_t i = 0; i < targets.size() / D; ++i) at.push_back(PointAt(targets, i));
    Triangulate(at);
    std::vector<double> result;
    result.reserve(at.size() * width_);
    Index near = 0;
    for (const Point<D>& p : at) {
      const auto& corners = triangulation_.vertices(triangulation_.Locate(p, near));
      std::array<Index, D + 1> v;
      std::copy(corners.begin(), corners.end(), v.begin());
      std::sort(v.begin(), v.end());  // so that the sum is a function of the positions' order
      near = v[0];
      Append(v, p, result);
    }
    return result;
  }

 private:
  using Index = std::uint32_t;
  static constexpr std::size_t kBoxCorners = std::size_t{1} << D;

  // -0 is 0: positions are compared by bits of coordinates in places.
  static Point<D> PointAt(std::span<const double> coordinates, std::size_t i) {
    Point<D> p;
    for (std::size_t k = 0; k < D; ++k) p.c[k] = coordinates[D * i + k] + 0.0;
    return p;
  }

  // The corners of a box around everything are sources, too, with the values of the nearest ones.
  void Triangulate(const std::vector<Point<D>>& targets) {
    Point<D> lo = points_[0], hi = points_[0];
    double extent = std::numeric_limits<double>::min();
    for (const std::vector<Point<D>>* const list :
         std::initializer_list<const std::vector<Point<D>>*>{&points_, &targets}) {
      for (const Point<D>& p : *list) {
        for (std::size_t k = 0; k < D; ++k) {
          lo.c[k] = std::min(lo.c[k], p.c[k]), hi.c[k] = std::max(hi.c[k], p.c[k]);
          extent = std::max({extent, hi.c[k] - lo.c[k], 0x1p-40 * std::abs(p.c[k])});
        }
      }
    }
    // So far away that no circle through sources, but for the flattest at the hull, contains a
    // corner.
    extent *= 0x1p20;
    for (std::size_t k = 0; k < D; ++k) lo.c[k] -= extent, hi.c[k] += extent;
    std::array<Index, kBoxCorners> corners;
    std::iota(corners.begin(), corners.end(), static_cast<Index>(count_));
    triangulation_.Reset(lo, hi, corners);
    for (const Index corner : corners) AddCorner(triangulation_.position(corner));
    std::vector<Index> indices(count_);
    std::iota(indices.begin(), indices.end(), Index{0});
    triangulation_.InsertAll(indices, std::span(points_).first(count_));
  }

  void AddCorner(const Point<D>& corner) {
    std::size_t nearest = 0;
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < count_; ++i) {
      const double distance = geometry::SquaredDistance(points_[i], corner);
      if (distance < least || (distance == least && points_[i] < points_[nearest])) {
        least = distance, nearest = i;
      }
    }
    points_.push_back(corner);
    for (std::size_t k = 0; k < width_; ++k) values_.push_back(values_[nearest * width_ + k]);
  }

  void Append(const std::array<Index, D + 1>& v, const Point<D>& p, std::vector<double>& to) const {
    Corners<D> corners;
    for (std::size_t j = 0; j <= D; ++j) {
      if (points_[v[j]] == p) {
        const auto first = values_.begin() + static_cast<std::ptrdiff_t>(v[j] * width_);
        to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(width_));
        return;
      }
      corners[j] = points_[v[j]].c;
    }
    const std::array<double, D + 1> weights = Barycentric<D>(corners)(p.c);
    for (std::size_t k = 0; k < width_; ++k) {
      double value = 0;
      double least = HUGE_VAL, most = -HUGE_VAL;
      for (std::size_t j = 0; j <= D; ++j) {
        const double at_corner = values_[v[j] * width_ + k];
        value += weights[j] * at_corner;
        least = std::min(least, at_corner), most = std::max(most, at_corner);
      }
      to.push_back(std::clamp(value, least, most));
    }
  }

  const std::size_t count_;  // of sources
  const std::size_t width_;  // values of a source
  std::vector<Point<D>> points_;
  std::vector<double> values_;
  delaunay::TriangulationOf<D> triangulation_;
};

}  // namespace

std::vector<double> InterpolateScattered(int dimension, std::span<const double> sources,
                                         std::span<const double> values,
                                         std::span<const double> targets) {
  return dimension == 2 ? ScatteredValues<2>(sources, values).At(targets)
                        : ScatteredValues<3>(sources, values).At(targets);
}

}  // namespace dynmesh::transfer
