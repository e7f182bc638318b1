#include "core/plc/draft.h"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/feature_kinds.h"
#include "core/base/size_shapes.h"
#include "core/plc/labels.h"
#include "core/plc/text.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

using State = DraftState;

absl::Status Refuse(absl::StatusCode code, const char* reason, FeatureId id, EditIndex edit,
                    std::string message) {
  return MakeError(code, std::move(message), {reason, {id}, static_cast<std::size_t>(edit)});
}

const char* NameOf(State state) {
  switch (state) {
    case State::kPoint:
      return "point";
    case State::kSegment:
      return "segment";
    case State::kPolygon:
      return "polygon";
    case State::kSize:
      return "sizing feature";
    case State::kAbsent:
      break;
  }
  return "feature";
}

// What to do instead of moving it.
std::string InsteadOfMove(State state, const std::array<FeatureId, 2>& ends) {
  switch (state) {
    case State::kSegment:
      return absl::StrCat("move points ", ends[0], " and ", ends[1], " instead");
    case State::kPolygon:
      return "move its points instead";
    case State::kSize:
    case State::kPoint:
    case State::kAbsent:
      break;
  }
  return "set it anew where it is to be";
}

absl::Status CheckId(FeatureId id, EditIndex edit) {
  if (id != kNoFeature && id <= kLastFeatureId) return absl::OkStatus();
  return Refuse(absl::StatusCode::kInvalidArgument, reason::kBadId, id, edit,
                absl::StrCat("feature id ", id, id == 0 ? " means none" : " is reserved",
                             "; choose one from 1 to ", kLastFeatureId));
}

absl::Status CheckPolygonId(FeatureId id, EditIndex edit) {
  if (id <= kLastPolygonId) return absl::OkStatus();
  return Refuse(absl::StatusCode::kInvalidArgument, reason::kBadId, id, edit,
                absl::StrCat("polygon ", id,
                             ": ids from 2^63 up stand for sets of polygons; choose "
                             "one from 1 to ",
                             kLastPolygonId));
}

absl::Status AbsentError(FeatureId id, EditIndex edit, const char* verb) {
  return Refuse(
      absl::StatusCode::kNotFound, reason::kUnknownFeature, id, edit,
      absl::StrCat("cannot ", verb, " feature ", id, ": there is none with that id; add it first"));
}

template <class Entry>
absl::Status CheckPresent(const Entry& entry, const char* verb) {
  if (entry.state != State::kAbsent) return absl::OkStatus();
  return AbsentError(entry.id, entry.edit, verb);
}

// -0 becomes +0, and what is past the dimension 0.
template <int D>
std::array<double, 3> Tidy(const std::array<double, 3>& given) {
  std::array<double, 3> p = {0, 0, 0};
  for (int k = 0; k < D; ++k) p[k] = given[k] + 0.0;
  return p;
}

template <int D>
geometry::Point<D> PointOf(const Feature& feature) {
  return CornerOf<D>(Tidy<D>(feature.position));
}

// Sets `entry` to `feature`, whatever it was.
template <int D>
absl::Status Become(const Feature& feature, typename Draft<D>::Entry& entry) {
  switch (feature.kind) {
    case FeatureKind::kPoint:
      entry.state = State::kPoint;
      entry.p = PointOf<D>(feature);
      return absl::OkStatus();
    case FeatureKind::kSegment:
      entry.state = State::kSegment;
      entry.ends = feature.ends;
      entry.is_marked = feature.unsplit;
      return absl::OkStatus();
    case FeatureKind::kSize:
      entry.state = State::kSize;
      entry.given = &feature;
      return absl::OkStatus();
    case FeatureKind::kPolygon:
      entry.state = State::kPolygon;
      entry.given = &feature;
      return CheckPolygonId(entry.id, entry.edit);
  }
  return Refuse(
      absl::StatusCode::kInvalidArgument, reason::kWrongKind, entry.id, entry.edit,
      absl::StrCat("feature ", entry.id, " is of unknown kind ", static_cast<int>(feature.kind),
                   "; only points, segments, polygons and sizes are"));
}

}  // namespace

template <int D>
SizeFeature<D> SizeOf(const Feature& feature) {
  SizeFeature<D> size;
  size.id = feature.id;
  const Sizing& given = feature.sizing;
  size.sizing.shape = given.shape;
  size.sizing.target = given.target;
  const SizeShapeUse* const use = FindUse(given.shape);
  if (use == nullptr || use->position) size.at = PointOf<D>(feature);
  if (use == nullptr) return size;
  if (use->radius) size.sizing.radius = given.radius;
  if (use->hi) size.sizing.hi = Tidy<D>(given.hi);
  if (use->rings) size.rings = feature.rings;
  if (use->path) {
    size.sizing.path.reserve(given.path.size());
    for (const auto& vertex : given.path) size.sizing.path.push_back(Tidy<D>(vertex));
  }
  return size;
}

template <int D>
Draft<D>::Draft(const FeatureStore<D>& base, const Edits& batch, Steps& steps) : base_(base) {
  entries_.reserve(batch.size());
  for (EditIndex i = 0; i < static_cast<EditIndex>(batch.size()); ++i) {
    if (steps.Stop()) return;
    const Feature& feature = batch.feature(i);
    absl::Status status = CheckId(feature.id, i);
    const bool is_of_label = batch.action(i) == Edit::Action::kSetLabel;
    if (status.ok() && !is_of_label) {
      Entry& entry = Touch(feature.id, i);
      if (error_edit_ == kNever) status = Act(batch.action(i), feature, entry);
      has_polygons_ |= entry.state == State::kPolygon;
    }
    if ((feature.label || is_of_label) && status.ok() && error_edit_ == kNever) {
      status = CheckLabelled(batch.action(i), feature, i);
    }
    if (!status.ok() && error_edit_ == kNever) {
      error_edit_ = i;
      error_ = std::move(status);
    }
  }
}

// The label of an edit, and whether the feature is there if the edit sets nothing else.
template <int D>
absl::Status Draft<D>::CheckLabelled(Edit::Action action, const Feature& feature,
                                     EditIndex edit) const {
  if (action == Edit::Action::kMove || action == Edit::Action::kRemove) return absl::OkStatus();
  if (action == Edit::Action::kSetLabel) {
    const Entry* const entry = Find(feature.id);
    const bool is_there =
        entry != nullptr ? entry->state != State::kAbsent : base_.Contains(feature.id);
    if (!is_there) return AbsentError(feature.id, edit, "label");
  }
  return CheckLabel(feature.id, *feature.label, edit);
}

// entries_.size() if no entry has that id.
template <int D>
std::size_t Draft<D>::PositionOf(FeatureId id) const {
  if (ascending_) {
    if (entries_.empty() || entries_.back().id < id) return entries_.size();
    const auto it =
        std::lower_bound(entries_.begin(), entries_.end(), id,
                         [](const Entry& e, FeatureId wanted) { return e.id < wanted; });
    return it->id == id ? static_cast<std::size_t>(it - entries_.begin()) : entries_.size();
  }
  const auto it = positions_.find(id);
  return it == positions_.end() ? entries_.size() : it->second;
}

template <int D>
const typename Draft<D>::Entry* Draft<D>::Find(FeatureId id) const {
  const std::size_t at = PositionOf(id);
  return at == entries_.size() ? nullptr : &entries_[at];
}

// Features named after the error are unknown.
template <int D>
bool Draft<D>::IsAsBefore(const Entry& entry) const {
  if (entry.edit >= error_edit_) return false;
  switch (entry.state) {
    case State::kPoint: {
      const PointRecord<D>* was = base_.FindPoint(entry.id);
      return was != nullptr && was->p == entry.p;
    }
    case State::kSegment: {
      const SegmentRecord* was = base_.FindSegment(entry.id);
      return was != nullptr && was->ends == entry.ends && was->is_marked == entry.is_marked;
    }
    case State::kSize: {
      const SizeFeature<D>* was = base_.FindSize(entry.id);
      if (was == nullptr || entry.given == nullptr) return was != nullptr;
      const SizeFeature<D> now = SizeOf<D>(*entry.given);
      return was->at == now.at && was->sizing == now.sizing && was->rings == now.rings;
    }
    case State::kPolygon: {
      const Rings* was = base_.FindPolygon(entry.id);
      return was != nullptr &&
             (entry.given == nullptr ||
              (*was == entry.given->rings && base_.IsUnsplit(entry.id) == entry.given->unsplit));
    }
    case State::kAbsent:
      break;
  }
  return false;
}

template <int D>
EditIndex Draft<D>::BlameOf(FeatureId id) const {
  const Entry* entry = Find(id);
  return entry == nullptr || IsAsBefore(*entry) ? kUntouched : entry->edit;
}

template <int D>
PolygonFeature Draft<D>::PolygonOf(const Entry& entry) const {
  if (entry.given != nullptr) return {entry.id, entry.given->rings, entry.given->unsplit};
  return {entry.id, *base_.FindPolygon(entry.id), base_.IsUnsplit(entry.id)};
}

template <int D>
SizeFeature<D> Draft<D>::SizeFeatureOf(const Entry& entry) const {
  return entry.given != nullptr ? SizeOf<D>(*entry.given) : *base_.FindSize(entry.id);
}

template <int D>
const geometry::Point<D>* Draft<D>::FindPoint(FeatureId id) const {
  if (const Entry* entry = Find(id)) {
    return entry->state == State::kPoint ? &entry->p : nullptr;
  }
  const PointRecord<D>* record = base_.FindPoint(id);
  return record == nullptr ? nullptr : &record->p;
}

// Touch asks for each.
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

template <int D>
typename Draft<D>::Entry& Draft<D>::Touch(FeatureId id, EditIndex edit) {
  const std::size_t at = PositionOf(id);
  if (at == entries_.size()) {
    if (ascending_ && !entries_.empty() && id < entries_.back().id) {
      ascending_ = false;
      positions_.reserve(entries_.capacity());
      for (std::size_t i = 0; i < entries_.size(); ++i) positions_.emplace(entries_[i].id, i);
    }
    if (!ascending_) positions_.emplace(id, at);
    Entry& entry = entries_.emplace_back();
    entry.id = id;
    if (const PointRecord<D>* point = base_.FindPoint(id)) {
      entry.state = State::kPoint;
      entry.p = point->p;
    } else if (const SegmentRecord* segment = base_.FindSegment(id)) {
      entry.state = State::kSegment;
      entry.ends = segment->ends;
      entry.is_marked = segment->is_marked;
    } else if (base_.FindSize(id) != nullptr) {
      entry.state = State::kSize;
    } else if (base_.FindPolygon(id) != nullptr) {
      entry.state = State::kPolygon;
      has_polygons_ = true;
    }
  }
  entries_[at].edit = edit;
  return entries_[at];
}

template <int D>
absl::Status Draft<D>::Act(Edit::Action action, const Feature& feature, Entry& entry) const {
  switch (action) {
    case Edit::Action::kAdd:
      if (entry.state != State::kAbsent) {
        return Refuse(absl::StatusCode::kAlreadyExists, reason::kIdInUse, entry.id, entry.edit,
                      absl::StrCat("cannot add feature ", entry.id, ": a ", NameOf(entry.state),
                                   " has that id; choose another id, or set to replace it"));
      }
      return Become<D>(feature, entry);
    case Edit::Action::kSet:
      if (absl::Status status = CheckPresent(entry, "set"); !status.ok()) return status;
      return Become<D>(feature, entry);
    case Edit::Action::kRemove:
      if (absl::Status status = CheckPresent(entry, "remove"); !status.ok()) return status;
      entry.state = State::kAbsent;
      return absl::OkStatus();
    case Edit::Action::kMove:
      if (absl::Status status = CheckPresent(entry, "move"); !status.ok()) return status;
      if (entry.state != State::kPoint) {
        return Refuse(
            absl::StatusCode::kInvalidArgument, reason::kWrongKind, entry.id, entry.edit,
            absl::StrCat("cannot move feature ", entry.id, ": it is a ", NameOf(entry.state), "; ",
                         InsteadOfMove(entry.state, entry.ends)));
      }
      entry.p = PointOf<D>(feature);
      return absl::OkStatus();
    case Edit::Action::kSetLabel:
      break;  // does not come here
  }
  return Refuse(absl::StatusCode::kInvalidArgument, reason::kWrongKind, entry.id, entry.edit,
                absl::StrCat("unknown action ", static_cast<int>(action), " on feature ", entry.id,
                             "; only add, set, remove, move and set label are"));
}

template SizeFeature<2> SizeOf(const Feature&);
template SizeFeature<3> SizeOf(const Feature&);
template class Draft<2>;
template class Draft<3>;

}  // namespace dynmesh::plc
