// The bound of vertices inside a segment (least_vertices.h).
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/segment_distance.h"
#include "core/plc/least_vertices.h"

namespace dynmesh::plc {
namespace {

using geometry::Point;

// A subsegment is at most so many times as long as the distance of its neighbour. With 2 % for
// rounding.
constexpr double kMostLength = 2 * 1.02;
// The distance along a stretch that is not halved: the greatest over the least.
constexpr double kEven = 1.3;
constexpr int kMostHalvings = 48;
// The most stretches of a segment. More would make the bound higher.
constexpr int kMostStretches = 512;

template <int D>
class Stretches {
 public:
  // `near`: not empty.
  Stretches(const SegmentFeature<D>& s, const std::vector<const SegmentFeature<D>*>& near,
            double limit)
      : lo_(s.q < s.p ? s.q : s.p), hi_(s.q < s.p ? s.p : s.q), near_(near), least_(limit / 2) {
    for (int k = 0; k < D; ++k) length2_ += (hi_[k] - lo_[k]) * (hi_[k] - lo_[k]);
    length_ = std::sqrt(length2_);
  }

  double Sum() {
    std::vector<double> cuts = {0, 1};
    for (const SegmentFeature<D>* const t : near_) {
      AddCut(t->p, cuts);
      AddCut(t->q, cuts);
      if constexpr (D == 3) AddNearest(*t, cuts);
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
    double sum = 0;
    Distances from = DistancesAt(cuts.front());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      Distances to = DistancesAt(cuts[i + 1]);
      sum += On(cuts[i], from, cuts[i + 1], to, kMostHalvings);
      from = std::move(to);
    }
    return sum;
  }

 private:
  using Distances = std::vector<double>;  // from each of near_

  // Where the foot of x is inside.
  void AddCut(const Point<D>& x, std::vector<double>& cuts) const {
    double along = 0;
    for (int k = 0; k < D; ++k) along += (hi_[k] - lo_[k]) * (x[k] - lo_[k]);
    if (along > 0 && along < length2_) cuts.push_back(along / length2_);
  }

  // Skew lines may be nearest inside both segments.
  void AddNearest(const SegmentFeature<D>& t, std::vector<double>& cuts) const {
    double uv = 0, vv = 0, uw = 0, vw = 0;
    for (int k = 0; k < D; ++k) {
      const double u = hi_[k] - lo_[k], v = t.q[k] - t.p[k], w = t.p[k] - lo_[k];
      uv += u * v, vv += v * v, uw += u * w, vw += v * w;
    }
    const double det = length2_ * vv - uv * uv;
    const double at = det > 0 ? (uw * vv - uv * vw) / det : 0;
    if (at > 0 && at < 1) cuts.push_back(at);
  }

  Distances DistancesAt(double at) const {
    Point<D> x;
    for (int k = 0; k < D; ++k) x[k] = lo_[k] + (hi_[k] - lo_[k]) * at;
    Distances distances;
    distances.reserve(near_.size());
    for (const SegmentFeature<D>* const t : near_) {
      distances.push_back(std::max(DistanceOf(*t, x), least_));
    }
    return distances;
  }

  double On(double a, const Distances& at_a, double b, const Distances& at_b, int halvings) {
    double most = INFINITY, least = INFINITY;
    for (std::size_t i = 0; i < near_.size(); ++i) {
      most = std::min(most, std::max(at_a[i], at_b[i]));
      least = std::min({least, at_a[i], at_b[i]});
    }
    const double length = (b - a) * length_;
    const double whole = std::max(0.0, length / (kMostLength * most) - 1);
    const bool is_even = most <= kEven * least, is_short = length <= kMostLength * least;
    if (is_even || is_short || halvings == 0 || ++stretches_ >= kMostStretches) return whole;
    const double middle = 0.5 * (a + b);
    const Distances at_middle = DistancesAt(middle);
    return std::max(whole, On(a, at_a, middle, at_middle, halvings - 1) +
                               On(middle, at_middle, b, at_b, halvings - 1));
  }

  const Point<D>&lo_, &hi_;
  const std::vector<const SegmentFeature<D>*>& near_;
  const double least_;
  double length2_ = 0, length_ = 0;
  int stretches_ = 0;
};

template <int D>
double LengthOf(const SegmentFeature<D>& s) {
  return std::sqrt(geometry::SquaredDistance(s.p, s.q));
}

}  // namespace

template <int D>
double LeastVerticesOn(const SegmentFeature<D>& s, std::span<const SegmentFeature<D>> near,
                       const Limits& limits, double limit) {
  std::vector<const SegmentFeature<D>*> disjoint;
  for (const SegmentFeature<D>& t : near) {
    if (!HaveCommonEnd(s, t)) disjoint.push_back(&t);
  }
  if (disjoint.empty()) return 0;
  const double parts = Stretches<D>(s, disjoint, limit).Sum();
  // Splits end at max_depth. k splits leave at most 2^-k of the length, or at sharp angles
  // (shells.h), as far as trials show, 2^(2-k).
  return std::min(std::max(0.0, parts - 1), std::exp2(limits.max_depth - 3));
}

template <int D>
double DistanceFor(const SegmentFeature<D>& s, double vertices) {
  return LengthOf(s) / (kMostLength * vertices);
}

template <int D>
double DistanceOf(const SegmentFeature<D>& t, const Point<D>& p) {
  const Point<D>& lo = t.q < t.p ? t.q : t.p;
  const Point<D>& hi = t.q < t.p ? t.p : t.q;
  double length2 = 0, along = 0;
  for (int k = 0; k < D; ++k) {
    length2 += (hi[k] - lo[k]) * (hi[k] - lo[k]);
    along += (hi[k] - lo[k]) * (p[k] - lo[k]);
  }
  if (along <= 0) return std::sqrt(geometry::SquaredDistance(p, lo));
  if (along >= length2) return std::sqrt(geometry::SquaredDistance(p, hi));
  double cross2 = 0;
  for (int i = 0; i < D; ++i) {
    for (int j = i + 1; j < D; ++j) {
      const double minor = (hi[i] - lo[i]) * (p[j] - lo[j]) - (hi[j] - lo[j]) * (p[i] - lo[i]);
      cross2 += minor * minor;
    }
  }
  return std::sqrt(cross2 / length2);
}

template double LeastVerticesOn(const SegmentFeature<2>&, std::span<const SegmentFeature<2>>,
                                const Limits&, double);
template double LeastVerticesOn(const SegmentFeature<3>&, std::span<const SegmentFeature<3>>,
                                const Limits&, double);
template double DistanceFor(const SegmentFeature<2>&, double);
template double DistanceFor(const SegmentFeature<3>&, double);
template double DistanceOf(const SegmentFeature<2>&, const Point<2>&);
template double DistanceOf(const SegmentFeature<3>&, const Point<3>&);

}  // namespace dynmesh::plc
