#include "core/plc/batch_check.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include "core/plc/far_apart.h"
#include "core/plc/messages.h"

namespace dynmesh::plc {
namespace {

using geometry::Point2;

template <typename F>
void SortById(std::vector<F>& features) {
  std::sort(features.begin(), features.end(), [](const F& a, const F& b) { return a.id < b.id; });
}

}  // namespace

BatchCheck::BatchCheck(const MeshOptions& options, double limit, const CellGrid& grid,
                       const FeatureStore& store, const SpatialIndex& index, const EditBatch& batch)
    : options_(options),
      limit_(limit),
      store_(store),
      present_(&index),
      draft_(store, batch),
      entered_(grid) {}

absl::StatusOr<Delta> BatchCheck::Run(absl::FunctionRef<bool()> interrupted) {
  for (const Draft::Entry& entry : draft_.entries()) {
    CollectPoint(entry);
    CollectSize(entry);
  }
  std::sort(affected_segments_.begin(), affected_segments_.end());
  affected_segments_.erase(std::unique(affected_segments_.begin(), affected_segments_.end()),
                           affected_segments_.end());
  for (const FeatureId id : affected_segments_) CollectSegment(id);
  if (IsCertainlyGood()) return TakeDelta();
  ChooseIndex();
  std::sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return std::tuple(a.edit, a.rank(), a.id) < std::tuple(b.edit, b.rank(), b.id);
  });
  for (const Event& event : events_) {
    if (interrupted()) return InterruptedError();
    if (absl::Status status = Handle(event); !status.ok()) return status;
  }
  if (!draft_.error().ok()) return draft_.error();
  return TakeDelta();
}

// A first load of points, all far apart: nothing to find fault with, no need of an order.
bool BatchCheck::IsCertainlyGood() const {
  if (store_.size() > 0 || draft_.error_edit() != kNever || !affected_segments_.empty() ||
      !delta_.added_sizes.empty()) {
    return false;
  }
  const auto is_in_place = [&](const PointFeature& p) {
    return CheckPlace(p, options_.box, 0).ok();
  };
  return std::all_of(delta_.added_points.begin(), delta_.added_points.end(), is_in_place) &&
         AreFarApart(delta_.added_points, options_.box, limit_);
}

// Events from the draft's error on mean nothing: their features are unknown.
void BatchCheck::Schedule(const Event& event) {
  if (event.edit < draft_.error_edit()) events_.push_back(event);
}

// The point that `entry` was and is, if it was or is one.
void BatchCheck::CollectPoint(const Draft::Entry& entry) {
  const bool is_point = entry.state == Draft::State::kPoint;
  const PointRecord* was = store_.FindPoint(entry.id);
  if (is_point && draft_.IsAsBefore(entry)) return;
  if (was != nullptr) {
    hidden_.insert(entry.id);
    delta_.removed_points.push_back({entry.id, was->p});
    const auto users = store_.SegmentsAt(entry.id);
    affected_segments_.insert(affected_segments_.end(), users.begin(), users.end());
  }
  if (is_point) {
    const auto at = static_cast<std::uint32_t>(delta_.added_points.size());
    delta_.added_points.push_back({entry.id, entry.p});
    Schedule({entry.edit, entry.id, Event::Kind::kPoint, at});
  }
  if (entry.state == Draft::State::kSegment || store_.FindSegment(entry.id) != nullptr) {
    affected_segments_.push_back(entry.id);
  }
}

void BatchCheck::CollectSize(const Draft::Entry& entry) {
  const bool is_size = entry.state == Draft::State::kSize;
  if (is_size && draft_.IsAsBefore(entry)) return;
  if (const SizeFeature* was = store_.FindSize(entry.id)) delta_.removed_sizes.push_back(*was);
  // Without a text of its own it is named after the draft's error only.
  if (!is_size || entry.size == nullptr) return;
  const auto at = static_cast<std::uint32_t>(delta_.added_sizes.size());
  delta_.added_sizes.push_back(SizeOf(*entry.size));
  Schedule({entry.edit, entry.id, Event::Kind::kSize, at});
}

// A segment that the batch names, or that ends at a point that changed.
void BatchCheck::CollectSegment(FeatureId id) {
  const SegmentRecord* was = store_.FindSegment(id);
  const Draft::Entry* entry = draft_.Find(id);
  const EditIndex own = draft_.BlameOf(id);
  const bool is_segment = entry == nullptr || entry->state == Draft::State::kSegment;
  const std::array<FeatureId, 2> ends = entry == nullptr ? was->ends : entry->ends;

  EditIndex edit = own;
  SegmentFeature now;
  const bool whole = is_segment && CheckEnds(id, ends, own);
  if (whole) {
    for (const FeatureId end : ends) edit = std::max(edit, draft_.BlameOf(end));
    now = {id, ends[0], ends[1], *draft_.FindPoint(ends[0]), *draft_.FindPoint(ends[1])};
  }
  if (was != nullptr) {
    const SegmentFeature before = store_.Expand(id, *was);
    if (whole && before == now && edit < draft_.error_edit()) return;
    hidden_.insert(id);
    delta_.removed_segments.push_back(before);
  }
  if (!whole) return;
  const auto at = static_cast<std::uint32_t>(delta_.added_segments.size());
  delta_.added_segments.push_back(now);
  Schedule({edit, id, Event::Kind::kSegment, at});
}

// Are both ends points, two of them? If not, schedules the problem: an end that is
// missing because of a later edit than the segment's is a point in use, else the
// segment's fault.
bool BatchCheck::CheckEnds(FeatureId id, const std::array<FeatureId, 2>& ends, EditIndex own) {
  if (ends[0] == ends[1]) {
    Schedule({own, id, Event::Kind::kDegenerate});
    return false;
  }
  bool whole = true, own_fault = false;
  for (const FeatureId end : ends) {
    if (draft_.FindPoint(end) != nullptr) continue;
    whole = false;
    const EditIndex edit = draft_.BlameOf(end);
    if (edit <= own) {
      own_fault = true;
      continue;
    }
    std::vector<FeatureId>& users = users_of_missing_[end];
    users.push_back(id);
    if (users.size() == 1) Schedule({edit, end, Event::Kind::kPointGone});
  }
  if (own_fault) Schedule({own, id, Event::Kind::kUnknownEnd});
  return whole;
}

// A batch that changes much of what is present would step over hidden features again
// and again; it then pays for an index of those that stay.
void BatchCheck::ChooseIndex() {
  constexpr std::size_t kWorthwhile = 8;
  if (hidden_.size() * kWorthwhile < store_.size()) return;
  present_ = nullptr;
  for (const auto& [id, record] : store_.points()) {
    if (!hidden_.contains(id)) entered_.Insert(PointFeature{id, record.p});
  }
  for (const auto& [id, record] : store_.segments()) {
    if (!hidden_.contains(id)) entered_.Insert(store_.Expand(id, record));
  }
}

absl::Status BatchCheck::Handle(const Event& event) {
  switch (event.kind) {
    case Event::Kind::kPoint:
      return EnterPoint(delta_.added_points[event.at], event.edit);
    case Event::Kind::kSegment:
      return EnterSegment(delta_.added_segments[event.at], event.edit);
    case Event::Kind::kPointGone:
      return PointInUseError(event.id, users_of_missing_[event.id], event.edit);
    case Event::Kind::kDegenerate:
      return DegenerateSegmentError(event.id, draft_.Find(event.id)->ends[0], event.edit);
    case Event::Kind::kUnknownEnd:
      return UnknownEnd(event.id, event.edit);
    case Event::Kind::kSize:
      return CheckSize(delta_.added_sizes[event.at], options_.box, limit_, event.edit);
  }
  return absl::OkStatus();
}

absl::Status BatchCheck::UnknownEnd(FeatureId segment, EditIndex edit) const {
  std::vector<FeatureId> missing;
  for (const FeatureId end : draft_.Find(segment)->ends) {
    if (draft_.FindPoint(end) == nullptr && draft_.BlameOf(end) <= edit) missing.push_back(end);
  }
  return UnknownEndError(segment, missing, edit);
}

absl::Status BatchCheck::EnterPoint(const PointFeature& point, EditIndex edit) {
  if (absl::Status status = CheckPlace(point, options_.box, edit); !status.ok()) return status;
  const Obstacle found = FindObstacle(point);
  if (found.conflict != Conflict::kNone) {
    const AnyFeature other = found.is_point ? AnyFeature(found.point) : AnyFeature(found.segment);
    return ConflictError(found.conflict, point, other, limit_, edit);
  }
  entered_.Insert(point);
  return absl::OkStatus();
}

absl::Status BatchCheck::EnterSegment(const SegmentFeature& segment, EditIndex edit) {
  const Obstacle found = FindObstacle(segment);
  if (found.conflict != Conflict::kNone) {
    const AnyFeature other = found.is_point ? AnyFeature(found.point) : AnyFeature(found.segment);
    return ConflictError(found.conflict, segment, other, limit_, edit);
  }
  entered_.Insert(segment);
  return absl::OkStatus();
}

namespace {

// What the index asks to be near to.
const Point2& Place(const PointFeature& f) { return f.p; }
const SegmentFeature& Place(const SegmentFeature& f) { return f; }

// The rules, whichever way round.
Conflict Judge(const PointFeature& f, const PointFeature& other, double limit) {
  return Between(f, other, limit);
}
Conflict Judge(const PointFeature& f, const SegmentFeature& other, double limit) {
  return Between(f, other, limit);
}
Conflict Judge(const SegmentFeature& f, const PointFeature& other, double limit) {
  return Between(other, f, limit);
}
Conflict Judge(const SegmentFeature& f, const SegmentFeature& other, double) {
  return Between(f, other);
}

}  // namespace

template <typename F>
BatchCheck::Obstacle BatchCheck::FindObstacle(const F& feature) {
  Obstacle least;
  FeatureId least_id = kNoFeature;
  const auto better = [&](Conflict conflict, FeatureId id) {
    if (conflict == Conflict::kNone ||
        std::tie(conflict, id) >= std::tie(least.conflict, least_id)) {
      return false;
    }
    least.conflict = conflict;
    least_id = id;
    return true;
  };
  const auto see_point = [&](const PointFeature& other) {
    if (!better(Judge(feature, other, limit_), other.id)) return;
    least.is_point = true;
    least.point = other;
  };
  const auto see_segment = [&](const SegmentFeature& other) {
    if (!better(Judge(feature, other, limit_), other.id)) return;
    least.is_point = false;
    least.segment = other;
  };
  if (present_ != nullptr) {
    present_->QueryNear(
        Place(feature),
        [&](const PointFeature& other) {
          if (!hidden_.contains(other.id)) see_point(other);
        },
        [&](const SegmentFeature& other) {
          if (!hidden_.contains(other.id)) see_segment(other);
        },
        &cost_);
  }
  entered_.QueryNear(Place(feature), see_point, see_segment, &cost_);
  return least;
}

Delta BatchCheck::TakeDelta() {
  SortById(delta_.removed_points);
  SortById(delta_.added_points);
  SortById(delta_.removed_segments);
  SortById(delta_.added_segments);
  SortById(delta_.removed_sizes);
  SortById(delta_.added_sizes);
  return std::move(delta_);
}

}  // namespace dynmesh::plc
