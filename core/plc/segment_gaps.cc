#include "core/plc/segment_gaps.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/geometry/segment_distance.h"
#include "core/plc/least_vertices.h"
#include "core/plc/rules.h"

namespace dynmesh::plc {
namespace {

using geometry::Point;

// The most segments for which neighbours are searched.
constexpr std::size_t kMostSegments = 16'384;
// The most neighbours of each.
constexpr std::size_t kMostNearest = 16;

// The end of either that is nearest to the other, put on s.
template <int D>
Point<D> NearestPlace(const SegmentFeature<D>& s, const SegmentFeature<D>& t) {
  Point<D> place = s.p;
  double least = INFINITY;
  const auto see = [&](const Point<D>& on_s, const Point<D>& on_t) {
    const double d2 = geometry::SquaredDistance(on_s, on_t);
    if (std::tie(d2, on_s) < std::tie(least, place)) least = d2, place = on_s;
  };
  for (const Point<D>& p : {s.p, s.q}) see(p, geometry::NearestOn(p, t.p, t.q));
  for (const Point<D>& p : {t.p, t.q}) see(geometry::NearestOn(p, s.p, s.q), p);
  return place;
}

}  // namespace

template <int D>
void NearestSegments<D>::Add(const SegmentFeature<D>& t) {
  if (HaveCommonEnd(s_, t)) return;
  const double distance = std::sqrt(geometry::SquaredDistance(s_.p, s_.q, t.p, t.q));
  if (!(distance <= reach_)) return;
  const EdgeKey key = KeyOf(t);
  const auto slot = std::find_if_not(nearest_.begin(), nearest_.end(), [&](const Entry& entry) {
    return std::pair(entry.distance, KeyOf(entry.segment)) < std::pair(distance, key);
  });
  if (slot != nearest_.end() && KeyOf(slot->segment) == key) return;  // visited before
  if (slot == nearest_.end() && nearest_.size() == kMostNearest) return;
  nearest_.insert(slot, {distance, t});
  if (nearest_.size() > kMostNearest) nearest_.pop_back();
}

template <int D>
SegmentGap<D> NearestSegments<D>::Gap(const Limits& limits, double limit) const {
  SegmentGap<D> gap;
  if (nearest_.empty()) return gap;
  std::vector<SegmentFeature<D>> near;
  double most = -1;
  for (const Entry& entry : nearest_) {
    near.push_back(entry.segment);
    const double alone = LeastVerticesOn<D>(s_, std::span(&entry.segment, 1), limits, limit);
    if (!(alone > most)) continue;
    most = alone;
    gap.other = entry.segment;
    gap.distance = entry.distance;
  }
  gap.vertices = LeastVerticesOn<D>(s_, near, limits, limit);
  gap.place = NearestPlace(s_, gap.other);
  return gap;
}

template <int D>
const typename SegmentGaps<D>::One& SegmentGaps<D>::Worst() const {
  return *std::min_element(gaps.begin(), gaps.end(), [](const One& a, const One& b) {
    return std::tie(b.gap.vertices, a.at) < std::tie(a.gap.vertices, b.at);
  });
}

template <int D>
double SegmentGaps<D>::DistanceBelowWhich(double most) const {
  std::vector<std::pair<double, double>> by_distance;
  for (const One& one : gaps) by_distance.emplace_back(one.gap.distance, one.gap.vertices);
  std::sort(by_distance.begin(), by_distance.end());
  double left = sum, distance = 0;
  for (const auto& [gap, vertices] : by_distance) {
    if (left <= most) break;
    left -= vertices;
    distance = gap;
  }
  return distance;
}

double NeedOf(std::size_t segments, double most) {
  return most / static_cast<double>(std::min(std::max<std::size_t>(segments, 1), kMostSegments));
}

template <int D>
SegmentGaps<D> FindSegmentGaps(std::span<const SegmentFeature<D>> segments, double need,
                               const Limits& limits, double limit, Steps& steps,
                               SegmentQuery<D> query) {
  struct Probed {
    double reach;  // neighbours farther away make fewer vertices than needed
    std::size_t at;
    bool operator<(const Probed& other) const {  // the greatest reach first
      return std::tie(other.reach, at) < std::tie(reach, other.at);
    }
  };
  std::vector<Probed> probed;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const double reach = DistanceFor(segments[i], need);
    if (reach > limit) probed.push_back({reach, i});  // no features are nearer than limit
  }
  if (probed.size() > kMostSegments) {
    std::nth_element(probed.begin(), probed.begin() + kMostSegments, probed.end());
    probed.resize(kMostSegments);
    std::sort(probed.begin(), probed.end());  // the sum has the same bits each time
  }
  SegmentGaps<D> found;
  for (const Probed& p : probed) {
    if (steps.Stop(16)) return found;
    const SegmentFeature<D>& s = segments[p.at];
    NearestSegments<D> nearest(s, p.reach);
    query(s, p.reach, [&](const SegmentFeature<D>& t) { nearest.Add(t); });
    SegmentGap<D> gap = nearest.Gap(limits, limit);
    if (!(gap.vertices > 0)) continue;
    found.sum += gap.vertices;
    found.gaps.push_back({p.at, std::move(gap)});
  }
  return found;
}

template <int D>
SegmentGaps<D> GapsAmong(std::span<const SegmentFeature<D>> segments, const MeshOptions& options,
                         double most, Steps& steps, SegmentQuery<D> also) {
  const double limit = CloseLimit(options);
  FeatureIndex<D> index(CellGrid<D>(options.box, limit));
  for (const SegmentFeature<D>& s : segments) {
    if (steps.Stop()) return {};
    index.Insert(s);
  }
  std::uint64_t cost = 0;
  return FindSegmentGaps<D>(segments, std::max(1.0, NeedOf(segments.size(), most / 100)),
                            options.limits, limit, steps,
                            [&](const SegmentFeature<D>& s, double distance,
                                absl::FunctionRef<void(const SegmentFeature<D>&)> visit) {
                              index.QueryWithin(s, distance, visit, &cost);
                              also(s, distance, visit);
                            });
}

template class NearestSegments<2>;
template class NearestSegments<3>;
template struct SegmentGaps<2>;
template struct SegmentGaps<3>;
template SegmentGaps<2> FindSegmentGaps(std::span<const SegmentFeature<2>>, double, const Limits&,
                                        double, Steps&, SegmentQuery<2>);
template SegmentGaps<3> FindSegmentGaps(std::span<const SegmentFeature<3>>, double, const Limits&,
                                        double, Steps&, SegmentQuery<3>);
template SegmentGaps<2> GapsAmong(std::span<const SegmentFeature<2>>, const MeshOptions&, double,
                                  Steps&, SegmentQuery<2>);
template SegmentGaps<3> GapsAmong(std::span<const SegmentFeature<3>>, const MeshOptions&, double,
                                  Steps&, SegmentQuery<3>);

}  // namespace dynmesh::plc
