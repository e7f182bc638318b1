#include "core/plc/feature_index.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/plc/rules.h"

namespace dynmesh::plc {

using geometry::Point2;

Slot FeatureIndex<2>::Insert(const SegmentFeature<2>& segment) {
  Placement placement{HubFor(segment), 0};
  if (placement.hub == kNoFeature) {
    placement.slot = general_.Insert(segment);
  } else {
    const bool at_p = placement.hub == segment.p_id;
    const Point2& apex = at_p ? segment.p : segment.q;
    const Point2& end = at_p ? segment.q : segment.p;
    std::unique_ptr<Hub>& hub = hubs_[placement.hub];
    if (hub == nullptr) hub = std::make_unique<Hub>(grid_, apex);
    placement.slot = hub->segments.Insert(segment);
    hub->by_angle.insert({end, placement.slot});
    for (int i = 0; i < 2; ++i) {
      hub->lo[i] = std::min(hub->lo[i], end[i]);
      hub->hi[i] = std::max(hub->hi[i], end[i]);
    }
  }
  CountAt(segment, 1);
  if (segment.unsplit) {
    placement.circle = unsplit_.try_emplace(LevelOf(segment), grid_).first->second.Insert(segment);
  }
  if (free_.empty()) {
    placements_.push_back(placement);
    return static_cast<Slot>(placements_.size() - 1);
  }
  const Slot slot = free_.back();
  free_.pop_back();
  placements_[slot] = placement;
  return slot;
}

void FeatureIndex<2>::EraseSegment(Slot slot) {
  const Placement placement = placements_[slot];
  free_.push_back(slot);
  const auto forget_circle = [&](const SegmentFeature<2>& segment) {
    if (segment.unsplit) unsplit_.at(LevelOf(segment)).EraseSegment(placement.circle);
  };
  if (placement.hub == kNoFeature) {
    CountAt(general_.segment(placement.slot), -1);
    forget_circle(general_.segment(placement.slot));
    general_.EraseSegment(placement.slot);
    return;
  }
  const auto it = hubs_.find(placement.hub);
  Hub& hub = *it->second;
  const SegmentFeature<2>& segment = hub.segments.segment(placement.slot);
  CountAt(segment, -1);
  forget_circle(segment);
  hub.by_angle.erase({placement.hub == segment.p_id ? segment.q : segment.p, placement.slot});
  hub.segments.EraseSegment(placement.slot);
  if (hub.by_angle.empty()) hubs_.erase(it);
}

void FeatureIndex<2>::CountAt(const SegmentFeature<2>& segment, int change) {
  for (const FeatureId end : {segment.p_id, segment.q_id}) {
    const auto it = degrees_.try_emplace(end, 0).first;
    it->second += static_cast<std::uint32_t>(change);
    if (it->second == 0) degrees_.erase(it);
  }
}

// The end that is a hub; of two hubs the one with more segments.
FeatureId FeatureIndex<2>::HubFor(const SegmentFeature<2>& segment) const {
  FeatureId hub = kNoFeature;
  std::uint32_t most = 0;
  for (const FeatureId end : {segment.p_id, segment.q_id}) {
    const auto it = degrees_.find(end);
    if (it == degrees_.end() || it->second < hub_degree_ || it->second <= most) continue;
    hub = end;
    most = it->second;
  }
  return hub;
}

// May the hub's segments be close to the box from lo to hi, or within `distance` of it?
bool FeatureIndex<2>::IsNear(const Hub& hub, const Point2& lo, const Point2& hi,
                             double distance) const {
  const double reach = grid_.LengthOf(2 * kCloseUnits) + distance;
  for (int i = 0; i < 2; ++i) {
    if (lo[i] - hub.hi[i] > reach || hub.lo[i] - hi[i] > reach) return false;
  }
  return true;
}

void FeatureIndex<2>::QueryNear(const Point2& p, VisitPoint visit_point, VisitSegment visit_segment,
                                std::uint64_t* cost) const {
  general_.QueryNear(p, visit_point, visit_segment, cost);
  for (const auto& [id, hub] : hubs_) {
    ++*cost;
    if (IsNear(*hub, p, p)) hub->segments.QueryNear(p, visit_point, visit_segment, cost);
  }
}

void FeatureIndex<2>::QueryWithin(const SegmentFeature<2>& s, double distance,
                                  VisitSegment visit_segment, std::uint64_t* cost) const {
  general_.QueryWithin(s, distance, visit_segment, cost);
  const Point2 lo = {{std::min(s.p[0], s.q[0]), std::min(s.p[1], s.q[1])}};
  const Point2 hi = {{std::max(s.p[0], s.q[0]), std::max(s.p[1], s.q[1])}};
  for (const auto& [id, hub] : hubs_) {
    ++*cost;
    if (id == s.p_id || id == s.q_id) continue;  // all its segments have that end
    if (IsNear(*hub, lo, hi, distance)) {
      hub->segments.QueryWithin(s, distance, visit_segment, cost);
    }
  }
}

int FeatureIndex<2>::LevelOf(const SegmentFeature<2>& segment) {
  return std::ilogb(geometry::SquaredDistance(segment.p, segment.q));
}

double FeatureIndex<2>::MostRadius(int level) {
  return 0.5 * std::sqrt(std::ldexp(1.0, level + 1));
}

void FeatureIndex<2>::QueryCircles(const Point2& p, VisitSegment visit_segment,
                                   std::uint64_t* cost) const {
  for (const auto& [level, segments] : unsplit_) {
    segments.QueryWithin(
        p, MostRadius(level), [](const PointFeature<2>&) {}, visit_segment, cost);
  }
}

void FeatureIndex<2>::QueryCircles(const SegmentFeature<2>& s, VisitSegment visit_segment,
                                   std::uint64_t* cost) const {
  for (const auto& [level, segments] : unsplit_) {
    segments.QueryWithin(s, MostRadius(level), visit_segment, cost);
  }
}

void FeatureIndex<2>::QueryCircleOver(const SegmentFeature<2>& s, VisitPoint visit_point,
                                      VisitSegment visit_segment, std::uint64_t* cost) const {
  const double radius = MostRadius(LevelOf(s));
  general_.QueryWithin(s, radius, visit_point, visit_segment, cost);
  const Point2 lo = {{std::min(s.p[0], s.q[0]), std::min(s.p[1], s.q[1])}};
  const Point2 hi = {{std::max(s.p[0], s.q[0]), std::max(s.p[1], s.q[1])}};
  for (const auto& [id, hub] : hubs_) {
    ++*cost;
    if (!IsNear(*hub, lo, hi, radius)) continue;
    hub->segments.QueryWithin(s, radius, visit_segment, cost);
  }
}

void FeatureIndex<2>::QueryNear(const SegmentFeature<2>& s, VisitPoint visit_point,
                                VisitSegment visit_segment, std::uint64_t* cost) const {
  general_.QueryNear(s, visit_point, visit_segment, cost);
  if (hubs_.empty()) return;
  const Point2 lo = {{std::min(s.p[0], s.q[0]), std::min(s.p[1], s.q[1])}};
  const Point2 hi = {{std::max(s.p[0], s.q[0]), std::max(s.p[1], s.q[1])}};
  for (const auto& [id, hub] : hubs_) {
    ++*cost;
    if (id == s.p_id || id == s.q_id) {
      VisitNeighbours(*hub, id == s.p_id ? s.q : s.p, visit_segment, cost);
    } else if (IsNear(*hub, lo, hi)) {
      hub->segments.QueryNear(s, visit_point, visit_segment, cost);
    }
  }
}

// In both directions, until angles are too large for a conflict.
void FeatureIndex<2>::VisitNeighbours(const Hub& hub, const Point2& end, VisitSegment visit_segment,
                                      std::uint64_t* cost) {
  const auto& spokes = hub.by_angle;
  const auto visit = [&](const Spoke& spoke) {
    ++*cost;
    if (AreAtClearAngle(hub.apex, end, spoke.end)) return false;
    visit_segment(hub.segments.segment(spoke.slot));
    return true;
  };
  const auto first = spokes.lower_bound(end);
  auto it = first;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    if (it == spokes.end()) it = spokes.begin();
    if (!visit(*it++)) break;
  }
  it = first;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    if (it == spokes.begin()) it = spokes.end();
    if (!visit(*--it)) break;
  }
}

std::size_t FeatureIndex<2>::bytes() const {
  std::size_t sum = general_.bytes() + placements_.size() * sizeof(placements_[0]) +
                    degrees_.capacity() * (sizeof(*degrees_.begin()) + 1);
  for (const auto& [level, segments] : unsplit_) sum += segments.bytes();
  for (const auto& [id, hub] : hubs_) {
    sum += hub->segments.bytes() + hub->by_angle.size() * sizeof(Spoke);
  }
  return sum;
}

std::size_t FeatureIndex<2>::node_count() const {
  std::size_t count = general_.node_count();
  for (const auto& [id, hub] : hubs_) count += hub->segments.node_count();
  return count;
}

}  // namespace dynmesh::plc
