#include "core/dynamic_mesh/region_labels.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "core/geometry/predicates.h"

namespace dynmesh {
namespace {

using geometry::Point2;

// Does a ray from p to the right cross the edge ab, which counts its lower end and not its
// upper? Nothing if p is on the edge. Exact.
std::optional<bool> RayCrosses(const Point2& p, const Point2& a, const Point2& b) {
  const Point2& lo = a[1] < b[1] || (a[1] == b[1] && a[0] < b[0]) ? a : b;
  const Point2& hi = &lo == &a ? b : a;
  if (p[1] < lo[1] || p[1] > hi[1]) return false;
  if (lo[1] == hi[1]) {
    return lo[0] <= p[0] && p[0] <= hi[0] ? std::nullopt : std::optional(false);
  }
  const int side = geometry::Orientation(lo, hi, p);
  if (side == 0) return std::nullopt;
  return side > 0 && p[1] < hi[1];
}

}  // namespace

void RegionLabels::AddWall(Vertex a, Vertex b, std::span<const FeatureId> polygons) {
  walls_[std::minmax(a, b)] = sets_.Add(polygons);
  wall_ends_.insert(a);
  wall_ends_.insert(b);
}

void RegionLabels::RemoveWall(Vertex a, Vertex b) {
  if (walls_.empty() || walls_.erase(std::minmax(a, b)) == 0) return;
  wall_ends_.insert(a);
  wall_ends_.insert(b);
}

RegionId RegionLabels::WallBetween(Vertex a, Vertex b) const {
  const auto it = walls_.find(std::minmax(a, b));
  return it == walls_.end() ? kNoRegion : it->second;
}

// On the edge of t opposite to its corner `corner`.
RegionId RegionLabels::WallAcross(Triangle t, int corner) const {
  const std::array<Vertex, 3>& v = triangulation_.vertices(t);
  return WallBetween(v[Triangulation::NextIndex(corner)], v[Triangulation::PreviousIndex(corner)]);
}

const std::vector<RegionLabels::Relabelled>& RegionLabels::Update(
    std::span<const Triangle> fresh, std::span<const Wall> toggled,
    absl::FunctionRef<bool(Vertex)> on_segment) {
  relabelled_.clear();
  if (empty()) {
    for (const Triangle t : fresh) triangulation_.set_tag(t, kNoRegion);
    return relabelled_;
  }
  labelled_ = true;
  settled_.clear();
  toggled_ = toggled;
  for (const Triangle t : fresh) SettleFrom(t, on_segment);
  if (!toggled_.empty()) {
    for (const Vertex v : wall_ends_) {
      if (!triangulation_.Contains(v)) continue;
      triangulation_.ForEachSimplexAround(v, [&](Triangle t) {
        if (!triangulation_.IsInfinite(t)) SettleFrom(t, on_segment);
      });
    }
  }
  wall_ends_.clear();
  return relabelled_;
}

// Settles `start` and all that is touched and connected with it.
void RegionLabels::SettleFrom(Triangle start, absl::FunctionRef<bool(Vertex)> on_segment) {
  if (settled_.contains(start) || !overfull().empty()) return;
  // The nearest triangle whose true label can be told.
  looked_at_.clear();
  looked_at_.insert(start);
  queue_.assign(1, start);
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    const Triangle t = queue_[i];
    if (const std::optional<RegionId> truth = TruthAt(t, on_segment)) {
      if (*truth == RegionSets::kTooMany) return;
      Settle(t, *truth);
      Spread(t);
      assert(settled_.contains(start) || !overfull().empty());
      return;
    }
    for (int c = 0; c < 3; ++c) {
      const Triangle next = triangulation_.Opposite({t, c}).simplex;
      if (triangulation_.IsInfinite(next) || !looked_at_.insert(next).second) continue;
      queue_.push_back(next);
    }
  }
  assert(false);  // the hull is outside of all polygons
}

// What the label of t has to be, if that can be seen from t alone.
std::optional<RegionId> RegionLabels::TruthAt(Triangle t,
                                              absl::FunctionRef<bool(Vertex)> on_segment) {
  if (settled_.contains(t)) return at(t);
  if (at(t) != kPending) {
    if (toggled_.empty()) return at(t);
    for (const Vertex v : triangulation_.vertices(t)) {
      // Inside a segment coordinates are rounded: no telling on which side of a wall.
      if (on_segment(v)) continue;
      const std::optional<RegionId> change = ChangeAt(triangulation_.position(v));
      if (change) return sets_.Toggle(at(t), *change);
    }
  }
  if (IsAtHull(t)) return kNoRegion;
  return std::nullopt;
}

// How the changed walls change the label of a place; nothing on such a wall.
std::optional<RegionId> RegionLabels::ChangeAt(const Point2& p) {
  std::vector<FeatureId> crossed;
  for (const Wall& wall : toggled_) {
    const std::optional<bool> crosses = RayCrosses(p, wall.p, wall.q);
    if (!crosses) return std::nullopt;
    if (*crosses) crossed.insert(crossed.end(), wall.polygons.begin(), wall.polygons.end());
  }
  std::sort(crossed.begin(), crossed.end());
  // Those crossed an odd number of times.
  std::vector<FeatureId> change;
  for (const FeatureId id : crossed) {
    if (change.empty() || change.back() != id) {
      change.push_back(id);
    } else {
      change.pop_back();
    }
  }
  return sets_.Add(change);
}

void RegionLabels::Settle(Triangle t, RegionId label) {
  const RegionId before = at(t);
  if (before != label) {
    if (before != kPending) relabelled_.push_back({t, before});
    triangulation_.set_tag(t, label);
  }
  settled_.insert(t);
}

void RegionLabels::Spread(Triangle from) {
  stack_.assign(1, from);
  while (!stack_.empty()) {
    const Triangle t = stack_.back();
    stack_.pop_back();
    for (int c = 0; c < 3; ++c) {
      const Triangle next = triangulation_.Opposite({t, c}).simplex;
      if (triangulation_.IsInfinite(next)) continue;
      const RegionId label = sets_.Toggle(at(t), WallAcross(t, c));
      if (label == RegionSets::kTooMany) return;
      if (settled_.contains(next)) {
        assert(at(next) == label);
        continue;
      }
      if (at(next) == label && !looked_at_.contains(next) && !IsTouched(next)) continue;
      Settle(next, label);
      stack_.push_back(next);
    }
  }
}

bool RegionLabels::IsTouched(Triangle t) const {
  if (toggled_.empty()) return false;
  const auto& v = triangulation_.vertices(t);
  return std::any_of(v.begin(), v.end(), [&](Vertex u) { return wall_ends_.contains(u); });
}

bool RegionLabels::IsAtHull(Triangle t) const {
  for (int c = 0; c < 3; ++c) {
    if (triangulation_.IsInfinite(triangulation_.Opposite({t, c}).simplex)) return true;
  }
  return false;
}

void RegionLabels::LabelAll() {
  wall_ends_.clear();
  if (empty()) return;
  labelled_ = true;
  std::vector<bool> has_wall;
  for (const auto& [edge, region] : walls_) {
    if (edge.second >= has_wall.size()) has_wall.resize(edge.second + std::size_t{1});
    has_wall[edge.first] = has_wall[edge.second] = true;
  }
  const auto may_have_wall = [&](Vertex v) { return v < has_wall.size() && has_wall[v]; };
  triangulation_.ForEachSimplex([&](Triangle t) { triangulation_.set_tag(t, kPending); });
  const Triangle first =
      triangulation_.Opposite(triangulation_.Around(Triangulation::kInfinite)).simplex;
  triangulation_.set_tag(first, kNoRegion);
  stack_.assign(1, first);
  while (!stack_.empty()) {
    const Triangle t = stack_.back();
    stack_.pop_back();
    const std::array<Vertex, 3> v = triangulation_.vertices(t);
    for (int c = 0; c < 3; ++c) {
      const Triangle next = triangulation_.Opposite({t, c}).simplex;
      if (triangulation_.IsInfinite(next) || at(next) != kPending) continue;
      const Vertex a = v[Triangulation::NextIndex(c)], b = v[Triangulation::PreviousIndex(c)];
      const bool may = may_have_wall(a) && may_have_wall(b);
      const RegionId label = may ? sets_.Toggle(at(t), WallBetween(a, b)) : at(t);
      if (label == RegionSets::kTooMany) continue;
      triangulation_.set_tag(next, label);
      stack_.push_back(next);
    }
  }
}

bool RegionLabels::Check() {
  if (empty()) return true;  // nobody has ever set one
  bool good = true;
  triangulation_.ForEachSimplex([&](Triangle t) {
    for (int c = 0; c < 3; ++c) {
      const Triangle next = triangulation_.Opposite({t, c}).simplex;
      const RegionId beyond = triangulation_.IsInfinite(next) ? kNoRegion : at(next);
      good = good && sets_.Toggle(at(t), WallAcross(t, c)) == beyond;
    }
  });
  return good;
}

void RegionLabels::Collect() {
  if (sets_.size() < collect_at_) return;
  absl::flat_hash_set<RegionId> used;
  triangulation_.ForEachSimplex([&](Triangle t) { used.insert(at(t)); });
  for (const auto& [edge, region] : walls_) used.insert(region);
  sets_.Keep(used);
  collect_at_ = 2 * sets_.size() + 1024;
}

}  // namespace dynmesh
