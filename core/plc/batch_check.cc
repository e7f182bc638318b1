#include "core/plc/batch_check.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "core/geometry/predicates.h"
#include "core/plc/facet_rules.h"
#include "core/plc/far_apart.h"
#include "core/plc/messages.h"
#include "core/plc/validation_terms.h"

namespace dynmesh::plc {

template <int D>
BatchCheck<D>::BatchCheck(const MeshOptions& options, double limit, const CellGrid<D>& grid,
                          const FeatureStore<D>& store, const FeatureIndex<D>& index,
                          const Edits& batch, Steps& steps)
    : options_(options),
      limit_(limit),
      store_(store),
      steps_(steps),
      present_(&index),
      draft_(store, batch, steps),
      entered_(grid, index.hub_degree()) {}

template <int D>
absl::StatusOr<Delta<D>> BatchCheck<D>::Run(Interrupted interrupted) {
  Collect();
  if (steps_.stopped()) return InterruptedError();
  const bool is_good = IsCertainlyGood();
  if (steps_.stopped()) return InterruptedError();
  if (is_good) return TakeDelta();
  ChooseIndex();
  if (steps_.stopped()) return InterruptedError();
  std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return std::tuple(a.edit, a.rank(), a.id, a.kind, a.at) <
           std::tuple(b.edit, b.rank(), b.id, b.kind, b.at);
  });
  std::size_t waiting = events_.size();
  for (const Event& event : events_) {
    if (interrupted(waiting--)) return InterruptedError();
    if (absl::Status status = Handle(event); !status.ok()) return status;
  }
  if (!draft_.error().ok()) return draft_.error();
  if (!splits_nothing()) {
    if (absl::Status status = CheckDemand(); !status.ok()) return status;
  }
  return TakeDelta();
}

template <int D>
absl::StatusOr<Delta<D>> BatchCheck<D>::RunValid() {
  Collect();
  if (steps_.stopped()) return InterruptedError();
  return TakeDelta();
}

// True for a first load of points that are all far apart: no problem is possible, no order needed.
template <int D>
bool BatchCheck<D>::IsCertainlyGood() const {
  if (store_.size() > 0 || draft_.error_edit() != kNever || !affected_segments_.empty() ||
      !affected_sizes_.empty() || draft_.has_polygons()) {
    return false;
  }
  const auto is_in_place = [&](const PointFeature<D>& p) {
    return !steps_.Stop() && CheckPosition(p, options_.box, 0).ok();
  };
  return std::all_of(delta_.added_points.begin(), delta_.added_points.end(), is_in_place) &&
         (!IsOn(ValidationTerm::kLoadsAreChecked) ||
          AreFarApart<D>(delta_.added_points, options_.box, limit_, steps_));
}

// A batch that changes many present features would visit hidden ones again and again. Then a new
// index of the features that stay is cheaper.
template <int D>
void BatchCheck<D>::ChooseIndex() {
  constexpr std::size_t kWorthwhile = 8;
  if ((hidden_.size() + hidden_edges_.size() + hidden_facets_.size()) * kWorthwhile < store_.size())
    return;
  present_ = nullptr;
  for (const auto& [id, record] : store_.points()) {
    if (steps_.Stop()) return;
    if (!hidden_.contains(id)) entered_.Insert(PointFeature<D>{id, record.p});
  }
  for (const auto& [id, record] : store_.segments()) {
    if (steps_.Stop()) return;
    if (!hidden_.contains(id)) entered_.Insert(store_.Expand(id, record));
  }
  for (const auto& [key, record] : store_.edges()) {
    if (steps_.Stop()) return;
    if (record.segment != kNoFeature || hidden_edges_.contains(key)) continue;
    entered_.Insert(store_.Expand(key, record));
  }
  if constexpr (D == 3) {
    for (const auto& [id, rings] : store_.polygons()) {
      if (steps_.Stop()) return;
      if (!hidden_facets_.contains(id)) entered_.Insert(Facet(store_.FacetOf(id, rings)));
    }
  }
}

template <int D>
absl::Status BatchCheck<D>::Handle(const Event& event) {
  switch (event.kind) {
    case Event::Kind::kPoint:
      return Enter(delta_.added_points[event.at], event.edit);
    case Event::Kind::kSegment:
      return Enter(delta_.added_segments[event.at], event.edit);
    case Event::Kind::kEdge:
      return Enter(edges_[event.at], event.edit);
    case Event::Kind::kPointGone: {
      if (!IsOn(ValidationTerm::kPointsInUseStay)) break;
      std::vector<FeatureId>& users = users_of_missing_[event.id];
      std::sort(users.begin(), users.end());
      return PointInUseError(event.id, users, event.edit);
    }
    case Event::Kind::kPolygon:
      if (auto status = CheckQuality(event.id, options_, event.edit); !status.ok()) return status;
      return CheckRings(event.id, draft_.PolygonOf(*draft_.Find(event.id)).rings, event.edit);
    case Event::Kind::kDegenerate:
      return DegenerateSegmentError(event.id, draft_.Find(event.id)->ends[0], event.edit);
    case Event::Kind::kUnknownEnd:
      if (!IsOn(ValidationTerm::kEndsExist)) break;
      return UnknownEnd(event.id, event.edit);
    case Event::Kind::kFacet:
      if constexpr (D == 3) return Enter(Facet(delta_.added_facets[event.at]), event.edit);
      break;
    case Event::Kind::kSize:
      if (splits_nothing()) return SizeUnusedError(event.id, options_, event.edit);
      return CheckSize(delta_.added_sizes[event.at], options_.box, limit_, event.edit);
  }
  return absl::OkStatus();
}

namespace {

using geometry::Point;

// The argument of a query of the index.
template <int D>
const Point<D>& PositionOf(const PointFeature<D>& f) {
  return f.p;
}
template <int D>
const SegmentFeature<D>& PositionOf(const SegmentFeature<D>& f) {
  return f;
}

[[maybe_unused]] const Facet& PositionOf(const Facet& f) { return f; }

// The rules with both orders of arguments.
template <class F, class G>
Conflict Judge(const F& f, const G& other, double limit) {
  return Between(f, other, limit);
}
template <int D>
Conflict Judge(const SegmentFeature<D>& f, const PointFeature<D>& other, double limit) {
  return Between(other, f, limit);
}
[[maybe_unused]] Conflict Judge(const Facet& f, const PointFeature<3>& other, double limit) {
  return Between(other, f, limit);
}
[[maybe_unused]] Conflict Judge(const Facet& f, const SegmentFeature<3>& other, double limit) {
  return Between(other, f, limit);
}

// Checks a feature by itself.
template <int D>
absl::Status CheckAlone(const PointFeature<D>& f, const MeshOptions& options, double,
                        EditIndex edit) {
  return CheckPosition(f, options.box, edit);
}
template <int D>
absl::Status CheckAlone(const SegmentFeature<D>& f, const MeshOptions& options, double,
                        EditIndex edit) {
  const bool may_be =
      D == 2 && options.kind == MeshKind::kDelaunay && options.criterion == Criterion::kEdge;
  return may_be || !f.unsplit ? absl::OkStatus() : UnsplitError<D>(f, options, edit);
}

[[maybe_unused]] absl::Status CheckAlone(const Facet& f, const MeshOptions&, double limit,
                                         EditIndex edit) {
  return CheckFacet(f, limit, edit);
}

}  // namespace

template <int D>
template <typename F>
absl::Status BatchCheck<D>::Enter(const F& feature, EditIndex edit) {
  if (absl::Status status = CheckAlone(feature, options_, limit_, edit); !status.ok())
    return status;
  const Obstacle found = FindObstacle(feature);
  if (found.conflict != Conflict::kNone) {
    return ConflictError<D>(found.conflict, feature, found.other, limit_, edit);
  }
  entered_.Insert(feature);
  return absl::OkStatus();
}

template <int D>
template <typename F>
typename BatchCheck<D>::Obstacle BatchCheck<D>::FindObstacle(const F& feature) {
  Obstacle least;
  // Edges of a polygon have the same id: then their ends decide.
  EdgeKey least_ends;
  FeatureId least_id = kNoFeature;
  const auto better = [&](Conflict conflict, FeatureId id, const EdgeKey& ends) {
    if (conflict == Conflict::kNone || (conflict == Conflict::kSmallAngle && splits_nothing()) ||
        std::tie(conflict, id, ends) >= std::tie(least.conflict, least_id, least_ends)) {
      return false;
    }
    least.conflict = conflict;
    least_id = id;
    least_ends = ends;
    return true;
  };
  const auto judge = [&](const auto& other) {
    const Conflict conflict = Judge(feature, other, limit_);
    return conflict == Conflict::kNone && Encroach(feature, other) ? Conflict::kEncroached
                                                                   : conflict;
  };
  const auto see_point = [&](const PointFeature<D>& other) {
    if (!better(judge(other), other.id, {})) return;
    least.other = other;
  };
  const auto see_segment = [&](const SegmentFeature<D>& other) {
    if (!better(judge(other), other.id, KeyOf(other))) return;
    least.other = other;
  };
  // Two facets may be near each other in as many visited cells as they have corners: judge once.
  absl::flat_hash_set<FeatureId> judged;
  const auto see_facet = [&](const Facet& other) {
    if constexpr (std::is_same_v<F, Facet>) {
      if (!judged.insert(other.id()).second) return;
    }
    if constexpr (D == 3) {
      if (better(Judge(feature, other, limit_), other.id(), {})) least.other = other;
    }
  };
  const auto ask = [&](const FeatureIndex<D>& index, auto point, auto segment, auto facet) {
    if constexpr (D == 3) {
      index.QueryNear(PositionOf(feature), point, segment, facet, &cost_);
    } else {
      index.QueryNear(PositionOf(feature), point, segment, &cost_);
      index.QueryCircles(PositionOf(feature), segment, &cost_);
      if constexpr (std::is_same_v<F, SegmentFeature<D>>) {
        if (feature.unsplit) index.QueryCircleOver(feature, point, segment, &cost_);
      }
    }
  };
  if (present_ != nullptr) {
    ask(
        *present_,
        [&](const PointFeature<D>& other) {
          if (!hidden_.contains(other.id) || !IsOn(ValidationTerm::kRemovedIsGone)) {
            see_point(other);
          }
        },
        [&](const SegmentFeature<D>& other) {
          if (!IsHidden(other)) see_segment(other);
        },
        [&](const Facet& other) {
          if (!hidden_facets_.contains(other.id())) see_facet(other);
        });
  }
  ask(entered_, see_point, see_segment, see_facet);
  return least;
}

template <int D>
template <typename F, typename G>
bool BatchCheck<D>::Encroach(const F& f, const G& g) {
  if constexpr (std::is_same_v<F, PointFeature<2>> && std::is_same_v<G, SegmentFeature<2>>) {
    return g.unsplit && IsInCircle(f, g);
  } else if constexpr (std::is_same_v<F, SegmentFeature<2>> && std::is_same_v<G, PointFeature<2>>) {
    return f.unsplit && IsInCircle(g, f);
  } else if constexpr (std::is_same_v<F, SegmentFeature<2>> &&
                       std::is_same_v<G, SegmentFeature<2>>) {
    return MayEncroach(f, g, limit_) || MayEncroach(g, f, limit_);
  }
  return false;
}

// Two points on the circle, one on each side of the segment, may keep it out of the triangulation.
template <int D>
bool BatchCheck<D>::IsInCircle(const PointFeature<2>& p, const SegmentFeature<2>& s) {
  bool is_in = false;
  if constexpr (D == 2) {
    const CircleSide side = SideOfCircle(p, s);
    if (side != CircleSide::kOn || !IsOn(ValidationTerm::kCirclesKeepEdges)) {
      return side == CircleSide::kInside;
    }
    const int of_p = geometry::Orientation(s.p, s.q, p.p);
    const auto see = [&](const PointFeature<2>& q) {
      is_in = is_in || (SideOfCircle(q, s) == CircleSide::kOn &&
                        geometry::Orientation(s.p, s.q, q.p) * of_p < 0);
    };
    const auto ignore = [](const SegmentFeature<2>&) {};
    entered_.QueryCircleOver(s, see, ignore, &cost_);
    if (present_ != nullptr) {
      present_->QueryCircleOver(
          s,
          [&](const PointFeature<2>& q) {
            if (!hidden_.contains(q.id)) see(q);
          },
          ignore, &cost_);
    }
  }
  return is_in;
}

template <int D>
Delta<D> BatchCheck<D>::TakeDelta() {
  delta_.Sort();
  return std::move(delta_);
}

template class BatchCheck<2>;
template class BatchCheck<3>;

}  // namespace dynmesh::plc
