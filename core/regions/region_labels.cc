#include "core/regions/region_labels.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "core/regions/region_terms.h"
#include "core/regions/sides.h"

namespace dynmesh {

template <int D>
void RegionLabels<D>::AddWall(const Side& side, std::span<const FeatureId> owners) {
  walls_[side] = sets_.Add(owners);
  wall_ends_.insert(side.begin(), side.end());
}

template <int D>
void RegionLabels<D>::RemoveWall(const Side& side) {
  if (walls_.empty() || walls_.erase(side) == 0) return;
  wall_ends_.insert(side.begin(), side.end());
}

// The owners of the wall opposite to corner `corner` of t; kNoRegion if there is none.
template <int D>
RegionId RegionLabels<D>::WallAcross(Simplex t, int corner) const {
  const auto it = walls_.find(SideOpposite(triangulation_.vertices(t), corner));
  return it == walls_.end() ? kNoRegion : it->second;
}

template <int D>
const std::vector<typename RegionLabels<D>::Relabelled>& RegionLabels<D>::Update(
    std::span<const Simplex> fresh, std::span<const Wall<D>> toggled,
    absl::FunctionRef<bool(Vertex)> is_rounded) {
  relabelled_.clear();
  if (empty()) {
    for (const Simplex t : fresh) triangulation_.set_tag(t, kNoRegion);
    return relabelled_;
  }
  labelled_ = true;
  settled_.clear();
  toggled_ = toggled;
  for (const Simplex t : fresh) SettleFrom(t, is_rounded);
  if (!toggled_.empty() && IsOn(RegionTerm::kWallEndsAreSearched)) {
    for (const Vertex v : wall_ends_) {
      if (!triangulation_.Contains(v)) continue;
      triangulation_.ForEachSimplexAround(v, [&](Simplex t) {
        if (!triangulation_.IsInfinite(t)) SettleFrom(t, is_rounded);
      });
    }
  }
  wall_ends_.clear();
  return relabelled_;
}

// Settles `start` and all touched simplices connected with it.
template <int D>
void RegionLabels<D>::SettleFrom(Simplex start, absl::FunctionRef<bool(Vertex)> is_rounded) {
  if (settled_.contains(start) || !overfull().empty()) return;
  // Breadth-first search for the nearest simplex with a known true label.
  looked_at_.clear();
  looked_at_.insert(start);
  queue_.assign(1, start);
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    const Simplex t = queue_[i];
    if (const std::optional<RegionId> truth = TruthAt(t, is_rounded)) {
      if (*truth == RegionSets::kTooMany) return;
      Settle(t, *truth);
      Spread(t);
      assert(settled_.contains(start) || !overfull().empty());
      return;
    }
    for (int c = 0; c <= D; ++c) {
      const Simplex next = triangulation_.Opposite({t, c}).simplex;
      if (triangulation_.IsInfinite(next) || !looked_at_.insert(next).second) continue;
      queue_.push_back(next);
    }
  }
  assert(false);  // the hull is outside of all polygons
}

// The true label of t, if t alone determines it.
template <int D>
std::optional<RegionId> RegionLabels<D>::TruthAt(Simplex t,
                                                 absl::FunctionRef<bool(Vertex)> is_rounded) {
  if (settled_.contains(t)) return at(t);
  if (at(t) != kPending) {
    if (toggled_.empty() || !IsOn(RegionTerm::kFlipsPropagate)) return at(t);
    for (const Vertex v : triangulation_.vertices(t)) {
      // Inside a segment or a facet coordinates are rounded: the side of a wall is unknown.
      if (is_rounded(v)) continue;
      const std::optional<RegionId> change = ChangeAt(triangulation_.position(v));
      if (change) return sets_.Toggle(at(t), *change);
    }
  }
  if (IsAtHull(t)) return kNoRegion;
  return std::nullopt;
}

// The owners of the changed walls that a ray from p crosses, once per crossing; nothing if the ray
// cannot decide.
template <int D>
std::optional<std::vector<FeatureId>> RegionLabels<D>::CrossedBy(int ray, const Point& p) const {
  std::vector<FeatureId> crossed;
  for (const Wall<D>& wall : toggled_) {
    const std::optional<bool> crosses = RayCrosses(ray, p, wall);
    if (!crosses) return std::nullopt;
    if (*crosses) crossed.insert(crossed.end(), wall.owners.begin(), wall.owners.end());
  }
  return crossed;
}

// The change of the label at a position by the changed walls; nothing on such a wall, or if no ray
// can decide.
template <int D>
std::optional<RegionId> RegionLabels<D>::ChangeAt(const Point& p) {
  std::optional<std::vector<FeatureId>> crossed;
  for (int ray = 0; ray < kRays<D> && !crossed; ++ray) crossed = CrossedBy(ray, p);
  if (!crossed) return std::nullopt;
  std::sort(crossed->begin(), crossed->end());
  // The owners crossed an odd number of times.
  std::vector<FeatureId> change;
  for (const FeatureId id : *crossed) {
    if (change.empty() || change.back() != id) {
      change.push_back(id);
    } else if (IsOn(RegionTerm::kTwiceIsOutside)) {
      change.pop_back();
    }
  }
  return sets_.Add(change);
}

template <int D>
void RegionLabels<D>::Settle(Simplex t, RegionId label) {
  const RegionId before = at(t);
  if (before != label) {
    if (before != kPending) relabelled_.push_back({t, before});
    triangulation_.set_tag(t, label);
  }
  settled_.insert(t);
}

template <int D>
void RegionLabels<D>::Spread(Simplex from) {
  stack_.assign(1, from);
  while (!stack_.empty()) {
    const Simplex t = stack_.back();
    stack_.pop_back();
    for (int c = 0; c <= D; ++c) {
      const Simplex next = triangulation_.Opposite({t, c}).simplex;
      if (triangulation_.IsInfinite(next)) continue;
      const bool separate = IsOn(RegionTerm::kWallsSeparate);
      const RegionId label = sets_.Toggle(at(t), separate ? WallAcross(t, c) : kNoRegion);
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

template <int D>
bool RegionLabels<D>::IsTouched(Simplex t) const {
  if (toggled_.empty()) return false;
  const auto& v = triangulation_.vertices(t);
  return std::any_of(v.begin(), v.end(), [&](Vertex u) { return wall_ends_.contains(u); });
}

template <int D>
bool RegionLabels<D>::IsAtHull(Simplex t) const {
  for (int c = 0; c <= D; ++c) {
    if (triangulation_.IsInfinite(triangulation_.Opposite({t, c}).simplex)) return true;
  }
  return false;
}

template <int D>
void RegionLabels<D>::LabelAll(Steps& steps) {
  wall_ends_.clear();
  if (empty()) return;
  labelled_ = true;
  std::vector<bool> has_wall;
  for (const auto& [side, region] : walls_) {
    if (side.back() >= has_wall.size()) has_wall.resize(side.back() + std::size_t{1});
    for (const Vertex v : side) has_wall[v] = true;
  }
  const auto may_have_wall = [&](Vertex v) { return v < has_wall.size() && has_wall[v]; };
  triangulation_.ForEachSimplex([&](Simplex t) { triangulation_.set_tag(t, kPending); });
  const Simplex first =
      triangulation_.Opposite(triangulation_.Around(Triangulation::kInfinite)).simplex;
  triangulation_.set_tag(first, kNoRegion);
  stack_.assign(1, first);
  while (!stack_.empty() && !steps.Stop()) {
    const Simplex t = stack_.back();
    stack_.pop_back();
    const std::array<Vertex, D + 1> v = triangulation_.vertices(t);
    for (int c = 0; c <= D; ++c) {
      const Simplex next = triangulation_.Opposite({t, c}).simplex;
      if (triangulation_.IsInfinite(next) || at(next) != kPending) continue;
      bool may = IsOn(RegionTerm::kWallsSeparateAll);
      for (int i = 0; i <= D; ++i)
        may = may && (i == c || may_have_wall(v[static_cast<std::size_t>(i)]));
      const RegionId label = may ? sets_.Toggle(at(t), WallAcross(t, c)) : at(t);
      if (label == RegionSets::kTooMany) continue;
      triangulation_.set_tag(next, label);
      stack_.push_back(next);
    }
  }
}

template <int D>
bool RegionLabels<D>::Check() {
  if (empty()) return true;  // no label was ever set
  bool good = true;
  triangulation_.ForEachSimplex([&](Simplex t) {
    for (int c = 0; c <= D; ++c) {
      const Simplex next = triangulation_.Opposite({t, c}).simplex;
      const RegionId beyond = triangulation_.IsInfinite(next) ? kNoRegion : at(next);
      good = good && sets_.Toggle(at(t), WallAcross(t, c)) == beyond;
    }
  });
  return good;
}

template <int D>
void RegionLabels<D>::Collect() {
  if (sets_.size() < collect_at_) return;
  absl::flat_hash_set<RegionId> used;
  triangulation_.ForEachSimplex([&](Simplex t) { used.insert(at(t)); });
  for (const auto& [side, region] : walls_) used.insert(region);
  sets_.Keep(used);
  collect_at_ = 2 * sets_.size() + 1024;
}

template class RegionLabels<2>;
template class RegionLabels<3>;

}  // namespace dynmesh
