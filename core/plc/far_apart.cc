#include "core/plc/far_apart.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::plc {
namespace {

using geometry::Point2;

// Points by vertical strips of the box, in each by y. Two points that are close stand in
// the same strip or in neighbouring ones.
class Strips {
 public:
  Strips(std::span<const PointFeature<2>> points, const Box& box, double limit) {
    const double width = box.hi[0] - box.lo[0];
    const double wanted = std::floor(std::sqrt(static_cast<double>(points.size())));
    const double count = std::clamp(std::floor(width / (4 * limit)), 1.0, std::max(wanted, 1.0));
    const double per_length = width > 0 ? count / width : 0;  // a box may be a line
    const auto strip_of = [&](const Point2& p) {
      return static_cast<std::size_t>(std::clamp((p[0] - box.lo[0]) * per_length, 0.0, count - 1));
    };
    begins_.assign(static_cast<std::size_t>(count) + 1, 0);
    for (const PointFeature<2>& f : points) ++begins_[strip_of(f.p) + 1];
    for (std::size_t s = 1; s < begins_.size(); ++s) begins_[s] += begins_[s - 1];
    std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
    points_.resize(points.size());
    for (const PointFeature<2>& f : points) points_[next[strip_of(f.p)]++] = f.p;
    for (std::size_t s = 0; s < size(); ++s) {
      std::sort(points_.begin() + begins_[s], points_.begin() + begins_[s + 1],
                [](const Point2& a, const Point2& b) { return a[1] < b[1]; });
    }
  }
  std::size_t size() const { return begins_.size() - 1; }
  std::span<const Point2> operator[](std::size_t strip) const {
    return std::span(points_).subspan(begins_[strip], begins_[strip + 1] - begins_[strip]);
  }

 private:
  std::vector<std::size_t> begins_;
  std::vector<Point2> points_;
};

}  // namespace

bool AreFarApart(std::span<const PointFeature<2>> points, const Box& box, double limit) {
  const Strips strips(points, box, limit);
  const double limit2 = limit * limit * (1 + 1e-9);
  std::size_t looks_left = 16 * points.size();
  // p against the points of `others` from `from` on that are not above it by more than limit.
  const auto is_far = [&](const Point2& p, std::span<const Point2> others, std::size_t from) {
    for (std::size_t i = from; i < others.size() && others[i][1] - p[1] <= limit; ++i) {
      if (looks_left-- == 0 || geometry::SquaredDistance(p, others[i]) <= limit2) return false;
    }
    return true;
  };
  for (std::size_t s = 0; s < strips.size(); ++s) {
    const auto own = strips[s];
    const auto right = s + 1 < strips.size() ? strips[s + 1] : std::span<const Point2>();
    std::size_t first = 0;  // of the right strip, not below p by more than limit
    for (std::size_t i = 0; i < own.size(); ++i) {
      while (first < right.size() && own[i][1] - right[first][1] > limit) ++first;
      if (!is_far(own[i], own, i + 1) || !is_far(own[i], right, first)) return false;
    }
  }
  return true;
}

}  // namespace dynmesh::plc
