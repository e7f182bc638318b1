// The procedures of svr.h, for sources that instantiate it.
#ifndef DYNMESH_CORE_SVR_SVR_PROCEDURES_H_
#define DYNMESH_CORE_SVR_SVR_PROCEDURES_H_

#include <algorithm>
#include <array>
#include <cmath>

#include "core/svr/svr.h"

namespace dynmesh::svr {

template <int D, class Input, class Location>
Svr<D, Input, Location>::Svr(const Options<D>& options, Input* input, Kernel<D>* mesh)
    : options_(options),
      input_(*input),
      mesh_(*mesh),
      location_(mesh_, positions_),
      waiting_(positions_, options.lo, options.hi) {
  for (const Point& p : input_.positions()) positions_.push_back(p);
  AddBorder();
  NearestSearch<D> nearest(mesh_, 0);
  for (const VertexIndex p : input_.Waiting()) {
    location_.Assign(p, nearest.Find(positions_[p]));
    waiting_.Add(p);
  }
  for (VertexIndex v = 0; v < input_.border_count(); ++v) EnterCrowded(v);
  mesh_.ForEachSimplex([&](SimplexIndex s) { Enter(s); });
}

template <int D, class Input, class Location>
void Svr<D, Input, Location>::AddBorder() {
  std::array<VertexIndex, std::size_t{1} << D> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<VertexIndex>(i);
  mesh_.Reset(options_.lo, options_.hi, corners);
  for (std::size_t i = corners.size(); i < input_.border_count(); ++i) {
    mesh_.Insert(static_cast<VertexIndex>(i), positions_[i], static_cast<VertexIndex>(i - 1));
  }
  is_entered_.assign(positions_.size(), false);
}

template <int D, class Input, class Location>
bool Svr<D, Input, Location>::IsInDomain(const Point& p) const {
  for (int k = 0; k < D; ++k) {
    if (!(options_.lo[k] <= p[k] && p[k] <= options_.hi[k])) return false;
  }
  return true;
}

// --- Work ---------------------------------------------------------------------------------

template <int D, class Input, class Location>
void Svr<D, Input, Location>::Enter(SimplexIndex s) {
  const Ball<D> ball = BallOf(mesh_, s);
  const double most2 = options_.quality * options_.quality * input_.SquaredShortestEdge(mesh_, s);
  if (ball.r2 <= most2 && !input_.IsTooLarge(ball)) return;
  mesh_.set_tag(s, ++serial_);
  const Kind kind = ball.r2 > kKept * kKept * most2 ? kSkinny : kModerate;
  work_[kind].push_back({kind, s, serial_});
}
template <int D, class Input, class Location>
void Svr<D, Input, Location>::EnterCrowded(VertexIndex v) {
  if (!location_.IsCrowded(v) || is_entered_[v]) return;
  is_entered_[v] = true;
  work_[kCrowded].push_back({kCrowded, v, 0});
}

template <int D, class Input, class Location>
bool Svr<D, Input, Location>::Stands(const Item& item) const {
  if constexpr (Input::kHasFeatures) {
    if (item.kind == kEncroached) return input_.IsPresent(item.of);
    if (item.kind == kFacets) return true;
  }
  if (item.kind == kCrowded) return location_.IsCrowded(item.of);
  return !mesh_.IsInfinite(item.of) && mesh_.tag(item.of) == item.serial;
}

template <int D, class Input, class Location>
bool Svr<D, Input, Location>::Next(Item* item) {
  do {
    for (LargeVector<Item>& work : work_) {
      while (!work.empty()) {
        *item = work.back();
        work.pop_back();
        if (Stands(*item)) return true;
        if (item->kind == kCrowded) is_entered_[item->of] = false;
      }
    }
  } while (EnterMissing());
  return false;
}

template <int D, class Input, class Location>
bool Svr<D, Input, Location>::EnterMissing() {
  if constexpr (Input::kHasFeatures) {
    input_.ForEachSubsegment([&](SubsegmentIndex s, VertexIndex a, VertexIndex b) {
      if (!IsEdge<D>(mesh_, a, b) && input_.CanSplit(s)) {
        work_[kEncroached].push_back({kEncroached, s, 0});
      }
    });
  }
  return !work_[kEncroached].empty();
}

template <int D, class Input, class Location>
void Svr<D, Input, Location>::Do(const Item& item) {
  switch (item.kind) {
    case kEncroached:
      ++counts_.encroached;
      DoEncroached(item.of);
      return;
    case kCrowded:
      ++counts_.crowded;
      is_entered_[item.of] = false;
      DoCrowded(item.of);
      EnterCrowded(item.of);
      return;
    case kFacets:
      ++counts_.facets;
      DoFacets(item);
      return;
    default:
      ++(item.kind == kSkinny ? counts_.skinny : counts_.moderate);
      if (Split(item.of) == Outcome::kYielded) work_[item.kind].push_back(item);
  }
}

// The new vertex waits in the cell that it is in: near the subsegment's ends, or their cells.
template <int D, class Input, class Location>
void Svr<D, Input, Location>::DoEncroached(SubsegmentIndex s) {
  if constexpr (Input::kHasFeatures) {
    const VertexIndex end = input_.LesserEnd(s);
    const VertexIndex v = input_.Split(s);
    positions_.push_back(input_.position(v));
    is_entered_.push_back(false);
    const VertexIndex near = mesh_.Contains(end) ? end : location_.OwnerOf(end);
    const VertexIndex owner = NearestVertex<D>(mesh_, positions_[v], near);
    EnterCrowded(location_.Assign(v, owner));
    waiting_.Add(v);
  }
}

template <int D, class Input, class Location>
void Svr<D, Input, Location>::DoCrowded(VertexIndex crowded) {
  const VertexIndex p = location_.AnyOf(crowded);
  const VertexIndex v = location_.OwnerOf(p);
  SimplexIndex largest = kNone;
  double most = 0;
  star_.ForEach(mesh_, v, [&](SimplexIndex s) {
    if (mesh_.IsInfinite(s)) return;
    const double r2 = BallOf(mesh_, s).r2;
    if (r2 > most && mesh_.Conflicts(s, positions_[p])) most = r2, largest = s;
  });
  if (largest == kNone) largest = ConflictNear(v, positions_[p]);
  // Points are far from a Steiner point, or it would have become one of them.
  if (input_.IsSteiner(v) || MayBeNear(v, p) || Split(largest) == Outcome::kLeft)
    InsertWaiting(p, largest);
}

// Vertices on one shell of a wedge are as near to each other as the wedge's angle makes them.
template <int D, class Input, class Location>
bool Svr<D, Input, Location>::MayBeNear(VertexIndex v, VertexIndex p) const {
  if constexpr (Input::kHasFeatures) return input_.complex().IsSeditious(v, p);
  return false;
}

template <int D, class Input, class Location>
void Svr<D, Input, Location>::DoFacets(const Item& item) {
  if constexpr (Input::kHasFeatures) {
    const auto found = input_.FindFacetPoint(mesh_, item.of);
    if (!found) return;
    work_[kFacets].push_back(item);  // until nothing is found
    InsertSteiner(*found, ConflictNear(item.of, found->p), 0);
  }
}

template <int D, class Input, class Location>
VertexIndex Svr<D, Input, Location>::FindWaiting(SimplexIndex s, const Ball<D>& ball) {
  const double radius = options_.k * std::sqrt(ball.r2);
  if (options_.asks_tree_first && std::isfinite(radius) && !waiting_.MayHavePoint(ball, radius)) {
    return kNone;
  }
  return location_.FindIn(s, ball, radius);
}

template <int D, class Input, class Location>
typename Svr<D, Input, Location>::Outcome Svr<D, Input, Location>::Split(SimplexIndex s) {
  const Ball<D> ball = BallOf(mesh_, s);
  const VertexIndex p = FindWaiting(s, ball);
  if (p != kNone) {
    ++counts_.warped;
    return InsertWaiting(p, s);
  }
  if (!std::isfinite(ball.r2) || !IsInDomain(ball.centre)) {
    ++counts_.outside;
    return Outcome::kLeft;
  }
  const double e2 = input_.SquaredShortestEdge(mesh_, s);
  if constexpr (Input::kHasFeatures) {
    return InsertSteiner(input_.MoveToFacet(ball), s, e2);
  }
  return InsertSteiner({ball.centre}, s, e2);
}

template <int D, class Input, class Location>
typename Svr<D, Input, Location>::Outcome Svr<D, Input, Location>::InsertWaiting(
    VertexIndex v, SimplexIndex conflicting) {
  const Outcome outcome = Protect(positions_[v], 0);
  if (outcome == Outcome::kInserted) Insert(v, conflicting, true);
  return outcome;
}

template <int D, class Input, class Location>
typename Svr<D, Input, Location>::Outcome Svr<D, Input, Location>::InsertSteiner(
    const SteinerPoint<D>& steiner, SimplexIndex conflicting, double e2) {
  const Outcome outcome = Protect(steiner.p, e2);
  if (outcome != Outcome::kInserted) return outcome;
  positions_.push_back(steiner.p);
  is_entered_.push_back(false);
  Insert(input_.AddSteiner(steiner), conflicting, false);
  return outcome;
}

template <int D, class Input, class Location>
typename Svr<D, Input, Location>::Outcome Svr<D, Input, Location>::Protect(const Point& p,
                                                                           double e2) {
  if constexpr (Input::kHasFeatures) {
    bool yields = false, guarded = false;
    input_.ForEachEncroached(p, [&](SubsegmentIndex s) {
      if (input_.IsGuarded(s, e2)) {
        guarded = true;
      } else if (input_.CanSplit(s)) {
        yields = true;
        work_[kEncroached].push_back({kEncroached, s, 0});
      }
    });
    if (yields) return Outcome::kYielded;
    if (guarded) {
      ++counts_.guarded;
      return Outcome::kLeft;
    }
  }
  return Outcome::kInserted;
}

template <int D, class Input, class Location>
void Svr<D, Input, Location>::Insert(VertexIndex v, SimplexIndex conflicting, bool was_waiting) {
  location_.Inserting(positions_[v], conflicting);
  mesh_.InsertAt(v, positions_[v], conflicting);
  input_.SetPresent(v);
  location_.Inserted(v, was_waiting);
  if (was_waiting) waiting_.Remove(v);
  EnterCrowded(v);
  if constexpr (Input::kHasFeatures) {
    if (input_.has_facets()) work_[kFacets].push_back({kFacets, v, 0});
  }
  for (const SimplexIndex s : mesh_.created()) {
    if (!mesh_.IsInfinite(s)) Enter(s);
  }
}

template <int D, class Input, class Location>
SimplexIndex Svr<D, Input, Location>::ConflictNear(VertexIndex v, const Point& p) {
  SimplexIndex conflicting = kNone;
  star_.ForEach(mesh_, NearestVertex<D>(mesh_, p, v), [&](SimplexIndex s) {
    if (conflicting == kNone && !mesh_.IsInfinite(s) && mesh_.Conflicts(s, p)) conflicting = s;
  });
  return conflicting;
}

template <int D, class Input, class Location>
double Svr<D, Input, Location>::WorstSquaredRatio() const {
  double worst = 0;
  mesh_.ForEachSimplex([&](SimplexIndex s) {
    const Ball<D> ball = BallOf(mesh_, s);
    if (!IsInDomain(ball.centre)) return;
    worst = std::max(worst, ball.r2 / input_.SquaredShortestEdge(mesh_, s));
  });
  return worst;
}

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_SVR_PROCEDURES_H_
