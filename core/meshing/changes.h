// Changes of state and their notifications. A vertex appears or vanishes at its creator's time; a
// subsegment is visible between its exposure and its death. Later operations that have read it
// become stale; the filters below decide which ones.
#ifndef DYNMESH_CORE_MESHING_CHANGES_H_
#define DYNMESH_CORE_MESHING_CHANGES_H_

#include <algorithm>
#include <utility>

#include "core/geometry/circumball.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/filter_terms.h"
#include "core/meshing/neighbourhood.h"
#include "core/meshing/refinement.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// --- Engine hooks -------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::Publish(sac::Output output, sac::Stamp at) {
  const std::uint32_t i = IndexOf(output);
  switch (WhatOf(output)) {
    case Made::kVertex:
      PublishVertex(i, at);
      break;
    case Made::kSubsegment:
      break;  // visible when its Check exposes it
    case Made::kExposure:
      SetExposed(i, at);
      break;
    case Made::kDeath: {
      Subsegment& s = subsegments_[i];
      const sac::Stamp old = s.death;
      if (old != sac::kNoStamp && !engine_.Precedes(at, old)) break;
      s.death = at;
      MarkSubsegmentChanged(i);
      NotifyOfSubsegment(i, at, old);
      if constexpr (!kTraced) HideSubsegment(i);  // no later operation reads it
      if constexpr (kTraced) {
        if (Counts(Term::kDeathOfSubsegment)) engine_.NotifyChain(s.operations, at);
      }
      break;
    }
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::Withdraw(sac::Output output, sac::Stamp at) {
  const std::uint32_t i = IndexOf(output);
  switch (WhatOf(output)) {
    case Made::kVertex:
      WithdrawVertex(i, at);
      break;
    case Made::kSubsegment:
      break;
    case Made::kExposure: {
      Subsegment& s = subsegments_[i];
      NotifyOfSubsegment(i, at, s.death);
      HideSubsegment(i);
      s.exposed = sac::kNoStamp;
      MarkSubsegmentChanged(i);
      break;
    }
    case Made::kDeath: {
      Subsegment& s = subsegments_[i];
      if (s.death != at) break;  // an earlier split is in force
      // A later split may exist, if a propagation was abandoned between the two.
      s.death = NextDeath(s, at);
      MarkSubsegmentChanged(i);
      NotifyOfSubsegment(i, at, s.death);
      if constexpr (kTraced) {
        if (Counts(Term::kDeathOfSubsegment)) engine_.NotifyChain(s.operations, at);
      }
      break;
    }
  }
}

// The earliest split of s other than that at time `except`.
template <int D, template <class> class E>
sac::Stamp Refinement<D, E>::NextDeath(const Subsegment& s, sac::Stamp except) const {
  sac::Stamp earliest = sac::kNoStamp;
  if constexpr (kTraced) {
    for (sac::OpId o = s.operations; o != sac::kNoOp; o = engine_.next_of_item(o)) {
      if (!engine_.executed(o) || engine_.stamp(o) == except) continue;
      const auto made = engine_.outputs(o);
      const bool split = std::any_of(made.begin(), made.end(),
                                     [](sac::Output m) { return WhatOf(m) == Made::kDeath; });
      if (split && (earliest == sac::kNoStamp || engine_.Precedes(engine_.stamp(o), earliest))) {
        earliest = engine_.stamp(o);
      }
    }
  }
  return earliest;
}

template <int D, template <class> class E>
void Refinement<D, E>::Release(sac::Output output) {
  if (WhatOf(output) == Made::kVertex) released_vertices_.push_back(IndexOf(output));
  if (WhatOf(output) == Made::kSubsegment) released_subsegments_.push_back(IndexOf(output));
}

// --- Vertices -----------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::PublishVertex(VertexIndex v, sac::Stamp at) {
  Vertex& vertex = vertices_[v];
  vertex.present = true;
  ++vertex_count_;
  // Where a triangulation answers everything except what a point encroaches on, the tree need only
  // be as fine as the subsegments.
  const bool is_of_cure = IsOfCure(vertex);
  if (is_of_cure) {
    cured_.Insert(v, vertex.p);
  } else if (!is_global() || (vertex.dimension < D && !box_only_)) {
    tree_.Insert(v, vertex.p);
  }
  const bool is_in = InsertIntoTriangulation(v);
  MarkChanged(v);
  if (kTraced && triangulation_ == nullptr && !is_of_cure) appeared_.push_back(v);
  NotifyOfVertex(v, true, at);
  if constexpr (!kTraced) {
    if (is_in && by_edge() && IsQualityEpoch(vertex.epoch)) RequestFirstGap(v);
  }
}

// False if there is no triangulation, or if it is full.
template <int D, template <class> class E>
bool Refinement<D, E>::InsertIntoTriangulation(VertexIndex v) {
  if (triangulation_ == nullptr) return false;
  const Point& p = vertices_[v].p;
  const auto known = std::exchange(gap_triangle_, Triangulation::kNone);
  triangulation_->InsertAt(
      v, p, known != Triangulation::kNone ? known : triangulation_->Locate(p, near_));
  if (triangulation_->is_full()) is_full_ = true;
  return !is_full_;
}

template <int D, template <class> class E>
void Refinement<D, E>::WithdrawVertex(VertexIndex v, sac::Stamp at) {
  Vertex& vertex = vertices_[v];
  vertex.present = false;
  --vertex_count_;
  MarkChanged(v);
  NotifyOfVertex(v, false, at);
  if (IsOfCure(vertex)) {
    cured_.Remove(v, vertex.p, [](std::uint32_t, std::uint32_t) {});
  } else if constexpr (kTraced) {
    tree_.Remove(v, vertex.p, [this](std::uint32_t first_child, std::uint32_t parent) {
      MovePlaces(first_child, parent);
    });
  }
}

// Leaves merge into their parent: their subscribers now subscribe at the parent.
template <int D, template <class> class E>
void Refinement<D, E>::MovePlaces(std::uint32_t first_child, std::uint32_t parent) {
  if constexpr (kTraced) {
    for (std::uint32_t child = first_child; child < first_child + (1u << D); ++child) {
      for (const sac::OpId op : engine_.subscriptions().Take(child)) {
        engine_.ReplacePlace(op, child, parent);
      }
      for (const SubsegmentIndex i : exposures_.Take(child)) {
        Subsegment& s = subsegments_[i];
        auto* const end = s.places.begin() + s.place_count;
        auto* const at = std::find(s.places.begin(), end, child);
        if (std::find(s.places.begin(), end, parent) == end) {
          *at = parent;
          exposures_.Add(parent, i);
        } else {
          *at = *(end - 1);
          --s.place_count;
        }
      }
    }
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::NotifyOfVertex(VertexIndex v, bool appears, sac::Stamp at) {
  if constexpr (kTraced) {
    if (!engine_.AnyAfter(at)) return;
    tree_.VisitPath(vertices_[v].p, [&](sac::Place place, sac::Parts part) {
      engine_.Notify(place, part, at, sac::kNoStamp,
                     [&](sac::OpId op) { return VertexMatters(op, v, appears); });
    });
  }
}

template <int D, template <class> class E>
bool Refinement<D, E>::VertexMatters(sac::OpId op, VertexIndex v, bool appears) const {
  if constexpr (kTraced) {
    const Point& y = vertices_[v].p;
    const Payload& payload = engine_.payload(op);
    const sac::Item item = engine_.item(op);
    const auto is_read = [&] {
      const auto reads = engine_.reads(op);
      return std::find(reads.begin(), reads.end(), v) != reads.end();
    };
    switch (engine_.kind(op)) {
      case kComplete:
        if (item == v || !payload.RegionMayHold(vertices_[item].p, y)) return false;
        return appears ? Counts(Term::kAppearsInCorner) && ConflictsWithStar(op, y)
                       : Counts(Term::kVanishesFromRing) && is_read();
      case kCure:
        return Counts(Term::kNearCure) && payload.RegionMayHold(CentreOfReads(op), y) &&
               CureMatters(op, v, appears);
      case kNearest:
        return item != v && geometry::SquaredDistance(vertices_[item].p, y) <= payload.radius2 &&
               Counts(appears ? Term::kAppearsNearer : Term::kNearestVanishes) &&
               NearestMatters(op, v, appears);
      case kCheck:
      case kRecheck: {
        if (payload.flag) return !appears && Counts(Term::kWitnessVanishes) && is_read();
        const Subsegment& s = subsegments_[item];
        return appears && Counts(Term::kAppearsInBall) && v != s.a && v != s.b &&
               DiametralBallSign(vertices_[s.a].p, vertices_[s.b].p, y) <= 0;
      }
      default:
        return false;
    }
  }
  return false;
}

// True if v changes the result of a Nearest. v is at most as far as the nearest vertex that `op`
// read. There may be very many at that distance: the one read stands for all.
template <int D, template <class> class E>
bool Refinement<D, E>::NearestMatters(sac::OpId op, VertexIndex v, bool appears) const {
  if constexpr (kTraced) {
    const auto reads = engine_.reads(op);
    if (reads.empty()) return true;
    if (!appears) return reads[0] == v;
    const Point& p = vertices_[engine_.item(op)].p;
    return geometry::SquaredDistance(p, vertices_[v].p) <
           geometry::SquaredDistance(p, vertices_[reads[0]].p);
  }
  return false;
}

// True if y would be a neighbour in the star that `op` read.
template <int D, template <class> class E>
bool Refinement<D, E>::ConflictsWithStar(sac::OpId op, const Point& y) const {
  if constexpr (kTraced) {
    const Point& p = vertices_[engine_.item(op)].p;
    const double reach = rules_.Reach(BucketOfEpoch(engine_.epoch(op)));
    const auto words = engine_.reads(op);
    if (y == p || words.empty()) return true;
    if constexpr (D == 2) {
      return ConflictsWithRing(words, p, reach, y);
    } else {
      return ConflictsWithLink(words, p, reach, y);
    }
  }
  return false;
}

// The position of a vertex or a ghost of the star at p.
template <int D, template <class> class E>
geometry::Point<D> Refinement<D, E>::PlaceOf(std::uint32_t id, const Point& p, double reach) const {
  return Star::IsGhost(id) ? Star::Ghost(p, reach, static_cast<int>(id - Star::kFirstGhost))
                           : vertices_[id].p;
}

template <int D, template <class> class E>
bool Refinement<D, E>::ConflictsWithRing(std::span<const std::uint32_t> ring, const Point& p,
                                         double reach, const Point& y) const {
  if constexpr (D == 2) {
    const int count = static_cast<int>(ring.size());
    const auto direction = [&](int i) {
      const Point q = PlaceOf(ring[i], p, reach);
      return std::pair(q[0] - p[0], q[1] - p[1]);
    };
    const auto conflicts = [&](int i) {
      const Point a = PlaceOf(ring[i], p, reach),
                  b = PlaceOf(ring[i + 1 == count ? 0 : i + 1], p, reach);
      return y == a || y == b || geometry::InCircle(p, a, b, y);
    };
    const int sector = Star::SectorOf(count, direction, y[0] - p[0], y[1] - p[1]);
    if (sector >= 0) return conflicts(sector);
    for (int i = 0; i < count; ++i) {
      if (conflicts(i)) return true;
    }
  }
  return false;
}

// The corner in `words` that is farthest in the given direction, if rounding leaves no doubt.
template <int D, template <class> class E>
std::optional<typename Refinement<D, E>::Corner> Refinement<D, E>::CornerTowards(
    std::span<const std::uint32_t> words, const Point& p, double reach,
    const std::array<double, D>& direction) const {
  if constexpr (D == 3) {
    constexpr std::size_t kFew = 64;
    const auto ids = NeighboursIn<D>(words);
    if (ids.size() > kFew) return std::nullopt;
    std::array<geometry::Vector3, kFew> directions;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      directions[i] = geometry::Difference(PlaceOf(ids[i], p, reach).c, p.c);
    }
    const auto triangles = words.subspan(ids.size());
    const int i = Star::CornerTowards(
        std::span(directions).first(ids.size()), static_cast<int>(triangles.size()),
        [&](int k) { return PlacesIn(triangles[k]); }, direction);
    if (i < 0) return std::nullopt;
    const auto [a, b, c] = PlacesIn(triangles[i]);
    return Corner{ids[a], ids[b], ids[c]};
  }
  return std::nullopt;
}

// `words`: as read, neighbours and then triangles.
template <int D, template <class> class E>
bool Refinement<D, E>::ConflictsWithLink(std::span<const std::uint32_t> words, const Point& p,
                                         double reach, const Point& y) const {
  if constexpr (D == 3) {
    const auto conflicts = [&](const Corner& ids) {
      const Point a = PlaceOf(ids[0], p, reach), b = PlaceOf(ids[1], p, reach),
                  c = PlaceOf(ids[2], p, reach);
      return y == a || y == b || y == c || geometry::InSphere(p, a, b, c, y);
    };
    const auto towards = CornerTowards(words, p, reach, geometry::Difference(y.c, p.c));
    if (towards.has_value()) return conflicts(*towards);
    return !ForEachCornerIn<D>(words, [&](const Corner& corner) { return !conflicts(corner); });
  }
  return false;
}

// The ball about a corner that `op` read; nothing if its error may be large.
template <int D, template <class> class E>
std::optional<typename SpatialTree<D>::Ball> Refinement<D, E>::BallOfCorner(
    sac::OpId op, const Corner& ids) const {
  if constexpr (kTraced) {
    const Point& p = vertices_[engine_.item(op)].p;
    const double reach = rules_.Reach(BucketOfEpoch(engine_.epoch(op)));
    std::array<Point, D> places;
    double shortest = INFINITY;
    for (int k = 0; k < D; ++k) {
      places[k] = PlaceOf(ids[k], p, reach);
      shortest = std::min(shortest, geometry::SquaredDistance(places[k], p));
    }
    const Point x = geometry::Circumcenter(places, p);
    const double r2 = geometry::SquaredDistance(x, p);
    if (r2 < 1e6 * shortest) return typename SpatialTree<D>::Ball{x, r2};
  }
  return std::nullopt;
}

// --- Features ---------------------------------------------------------------------------

// The point a (b = a) or the segment ab.
template <int D, template <class> class E>
InputFeature<D> Refinement<D, E>::FeatureOf(VertexIndex a, VertexIndex b) const {
  return {a, b, vertices_[a].p, vertices_[b].p};
}

template <int D, template <class> class E>
Extent<D> Refinement<D, E>::BoxOf(const InputFeature<D>& feature) {
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(feature.p, 0);
  box.AddBall(feature.q, 0);
  return box;
}

// From now on features are kept by position. Nothing has depended on their positions so far, so the
// present ones count as unchanged.
template <int D, template <class> class E>
void Refinement<D, E>::IndexFeatures() {
  if (std::exchange(indexes_features_, true)) return;
  for (VertexIndex v = 0; v < vertices_.size(); ++v) {
    const Vertex& vertex = vertices_[v];
    const bool is_point = vertex.present && vertex.creator == sac::kNoOp;
    if (is_point && vertex.feature != 0) features_.Add(FeatureOf(v, v));
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::AddFeature(const InputFeature<D>& feature) {
  features_.Add(feature);
  if constexpr (kTraced) changed_features_.emplace_back(feature, true);
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveFeature(const InputFeature<D>& feature) {
  features_.Remove(feature);
  if constexpr (kTraced) changed_features_.emplace_back(feature, false);
}

// A segment of which only the shape or the owner changed was removed and added: no change.
template <int D, template <class> class E>
void Refinement<D, E>::KeepNetChanges() {
  std::sort(changed_features_.begin(), changed_features_.end(), [](const auto& x, const auto& y) {
    return std::pair(x.first.a, x.first.b) < std::pair(y.first.a, y.first.b);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0, next = 0; i < changed_features_.size(); i = next) {
    const InputFeature<D> f = changed_features_[i].first;
    int net = 0;
    for (; next < changed_features_.size() && changed_features_[next].first == f; ++next) {
      net += changed_features_[next].second ? 1 : -1;
    }
    if (net != 0) changed_features_[kept++] = {f, net > 0};
  }
  changed_features_.resize(kept);
}

// Notifies of features that came or went since the last propagation.
template <int D, template <class> class E>
void Refinement<D, E>::NotifyOfFeatures() {
  for (const auto& [f, came] : changed_features_) {
    NotifyFromBeginning(
        BoxOf(f),
        [&f = f](const Point& centre, double half) {
          return geometry::MayMeetCube(centre, half * (1 + 1e-9), f.p, f.q);
        },
        [this, &f = f, came = came](sac::OpId op) { return FeatureMatters(op, f, came); });
  }
  changed_features_.clear();
}

template <int D, template <class> class E>
bool Refinement<D, E>::FeatureMatters(sac::OpId op, const InputFeature<D>& feature,
                                      bool appears) const {
  if constexpr (kTraced) {
    if (engine_.kind(op) != kPresplit) return false;
    const Subsegment& s = subsegments_[engine_.item(op)];
    if (!feature.IsDisjoint(s.whole_a, s.whole_b)) return false;
    const Payload& payload = engine_.payload(op);
    if (!appears) {
      const auto reads = engine_.reads(op);
      return payload.flag && Counts(Term::kTooNearVanishes) && !reads.empty() &&
             reads[0] == feature.a && reads[1] == feature.b;
    }
    if (!Counts(payload.flag ? Term::kFeatureNearer : Term::kFeatureTooNear)) return false;
    const Point middle = geometry::Midpoint(vertices_[s.a].p, vertices_[s.b].p);
    const double d2 = geometry::SquaredDistance(middle, feature.p, feature.q);
    return (!payload.flag || d2 <= payload.radius2) && IsTooNear(s, feature, d2);
  }
  return false;
}

// --- Sizing ---------------------------------------------------------------------------

// Notifies of a change of state outside the time of the trace, which holds from the beginning.
// Visits the operations that read in cells that meet the box and for which keep(centre, half the
// side) is true. Marks stale those for which matters(operation) is true.
template <int D, template <class> class E>
template <class Keep, class Matters>
void Refinement<D, E>::NotifyFromBeginning(const Extent<D>& box, Keep keep, Matters matters) {
  if constexpr (kTraced) {
    if (!engine_.AnyAfter(engine_.beginning())) return;
    tree_.VisitBoxIf(box, keep, [&](sac::Place place) {
      engine_.Notify(place, engine_.beginning(), sac::kNoStamp, matters);
    });
  }
}

// An operation subscribes in cells at least half as large as the box of what it read
// (SpatialTree::Cover). So cells smaller than the balls that the region allows have no subscriber
// to notify.
template <int D, template <class> class E>
void Refinement<D, E>::NotifyOfSizing(const SizingRegion<D>& region) {
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(region.lo, region.radius);
  box.AddBall(region.hi, region.radius);
  const double least_half = region.most_radius() * (1 - 1e-6) - rules_.ulp();
  NotifyFromBeginning(
      box, [&](const Point&, double half) { return half >= least_half; },
      [&](sac::OpId op) { return SizingMatters(op, region); });
}

// May `op` have found a ball too large for the region, or find one now? Conservative: may return
// true needlessly. It judged the balls about the corners of the star that it read. If it made
// vertices, it also judged the corners of the smaller stars that they left. Those balls lie within
// the union of the former, and none is larger than the largest of them.
template <int D, template <class> class E>
bool Refinement<D, E>::SizingMatters(sac::OpId op, const SizingRegion<D>& region) const {
  if constexpr (kTraced) {
    if (!Counts(Term::kOverSize)) return false;
    if (engine_.kind(op) == kPresplit) {
      return !engine_.payload(op).flag && IsTooLong(subsegments_[engine_.item(op)], region);
    }
    if (engine_.kind(op) == kCure) {
      return region.Meets(CentreOfReads(op), std::sqrt(double{engine_.payload(op).radius2}));
    }
    if (engine_.kind(op) != kComplete) return false;
    const auto outputs = engine_.outputs(op);
    const bool made = std::any_of(outputs.begin(), outputs.end(),
                                  [](sac::Output o) { return WhatOf(o) == Made::kVertex; });
    const double most = region.most_radius(),
                 view = std::sqrt(static_cast<double>(engine_.payload(op).radius2));
    const Point& p = vertices_[engine_.item(op)].p;
    bool meets = false, too_large = false, both = false, unsure = false;
    const bool kept = ForEachCornerIn<D>(engine_.reads(op), [&](const Corner& ids) {
      const bool at_end = std::ranges::any_of(ids, Star::IsGhost);
      // By edges, a size limits triangles and tetrahedra of the mesh alone.
      if (at_end && by_edge() && !made) return true;
      const auto ball = BallOfCorner(op, ids);
      if (!ball.has_value() && !at_end) {
        unsure = true;
        return false;
      }
      const double r =
          ball.has_value() ? std::sqrt(ball->radius2) * (1 + 1e-6) + rules_.ulp() : view;
      const bool is_met = region.Meets(ball.has_value() ? ball->centre : p, r), is_large = most < r;
      meets = meets || is_met;
      too_large = too_large || is_large;
      both = both || (is_met && is_large);
      return true;
    });
    if (unsure || !kept) return true;
    return made ? meets && too_large : both;
  }
  return false;
}

// --- Subsegments --------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::SetExposed(SubsegmentIndex i, sac::Stamp at) {
  Subsegment& s = subsegments_[i];
  s.exposed = at;
  s.place_count = 0;
  tree_.Cover(BallOf(s), [&](sac::Place place, sac::Parts parts) {
    subsegments_[i].places[subsegments_[i].place_count++] = place;
    exposures_.Add(place, i, parts);
  });
  MarkSubsegmentChanged(i);
  NotifyOfSubsegment(i, at, s.death);
}

template <int D, template <class> class E>
void Refinement<D, E>::HideSubsegment(SubsegmentIndex i) {
  Subsegment& s = subsegments_[i];
  for (int k = 0; k < s.place_count; ++k) exposures_.Remove(s.places[k], i);
  s.place_count = 0;
}

// If s is exposed, notifies operations with a time in (after, until]: those that made a vertex in
// its ball, and those that yielded or were kept out, perhaps because of it. Most operations did
// neither and are not visited.
template <int D, template <class> class E>
void Refinement<D, E>::NotifyOfSubsegment(SubsegmentIndex i, sac::Stamp after, sac::Stamp until) {
  if constexpr (kTraced) {
    const Subsegment& s = subsegments_[i];
    if (s.exposed == sac::kNoStamp || !engine_.AnyAfter(after)) return;
    const Point &a = vertices_[s.a].p, &b = vertices_[s.b].p;
    const Point middle = geometry::Midpoint(a, b);
    const double radius = RadiusOf(s);
    double r2 = radius * radius;
    const auto notify_maker = [&](std::uint32_t x, const Point& p, double) {
      const sac::OpId maker = vertices_[x].creator;
      if (maker == sac::kNoOp || x == s.a || x == s.b) return;
      engine_.NotifyOperation(maker, after, until, [&](sac::OpId op) {
        const bool is_steiner = engine_.kind(op) == kComplete || engine_.kind(op) == kCure;
        return Counts(is_steiner ? Term::kOverSteinerPoint : Term::kOverMidpoint) &&
               DiametralBallSign(a, b, p) <= 0;
      });
    };
    tree_.VisitBall(middle, r2, notify_maker);
    if (slivers_.is_on()) cured_.VisitBall(middle, r2, notify_maker);
    tree_.VisitCells({middle, r2}, [&](sac::Place place) {
      engine_.NotifyAttentive(place, after, until, [&](sac::OpId op) {
        // The candidate was in one of the balls read.
        const double far = std::sqrt(engine_.payload(op).radius2) + radius;
        return Counts(Term::kOverYieldedCandidate) &&
               geometry::SquaredDistance(CentreOfReads(op), middle) <= far * far;
      });
    });
  }
}

// --- Book-keeping ---------------------------------------------------------------------

// A vertex near which the operation works.
template <int D, template <class> class E>
VertexIndex Refinement<D, E>::VertexOf(sac::Kind kind, sac::Item item) const {
  if (kind == kCure) return slivers_[item].v[0];
  return kind <= kComplete ? item : subsegments_[item].a;
}

// The point from which the payload of a Complete or a Cure measures what was read.
template <int D, template <class> class E>
geometry::Point<D> Refinement<D, E>::CentreOfReads(sac::OpId op) const {
  if constexpr (kTraced) {
    const sac::Item item = engine_.item(op);
    if constexpr (D == 3) {
      if (engine_.kind(op) == kCure) return slivers_[item].centre;
    }
    return vertices_[item].p;
  }
  return {};
}

template <int D, template <class> class E>
void Refinement<D, E>::MarkChanged(VertexIndex v) {
  if (slivers_.is_on() && !IsOfCure(vertices_[v])) changed_base_.push_back(v);
  if (vertices_[v].changed) return;
  vertices_[v].changed = true;
  changed_vertices_.push_back(v);
}

template <int D, template <class> class E>
void Refinement<D, E>::MarkSubsegmentChanged(SubsegmentIndex s) {
  if (subsegments_[s].changed) return;
  subsegments_[s].changed = true;
  changed_subsegments_.push_back(s);
}

template <int D, template <class> class E>
VertexIndex Refinement<D, E>::NewVertex() {
  if (free_vertices_.empty()) {
    vertices_.emplace_back();
    if (vertices_.size() > kMostElements) is_full_ = true;
    return static_cast<VertexIndex>(vertices_.size() - 1);
  }
  const VertexIndex v = free_vertices_.back();
  free_vertices_.pop_back();
  vertices_[v] = {};
  return v;
}

template <int D, template <class> class E>
SubsegmentIndex Refinement<D, E>::NewSubsegment() {
  if (free_subsegments_.empty()) {
    subsegments_.emplace_back();
    if (subsegments_.size() > kMostElements) is_full_ = true;
    return static_cast<SubsegmentIndex>(subsegments_.size() - 1);
  }
  const SubsegmentIndex s = free_subsegments_.back();
  free_subsegments_.pop_back();
  subsegments_[s] = {};
  return s;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CHANGES_H_
