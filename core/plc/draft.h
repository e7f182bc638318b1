// The feature set that a batch of edits requests, as a difference to the present one.
//
// Edits act in order. An edit that cannot act (bad id, wrong kind, id in use, unknown feature, bad
// label) is the draft's error. There is no other validation here. Edits after the error are not
// applied; their features are only marked as touched. Labels are no part of the draft (labels.h),
// and an edit of a label touches no feature. Thread-safe once constructed. O(batch).
#ifndef DYNMESH_CORE_PLC_DRAFT_H_
#define DYNMESH_CORE_PLC_DRAFT_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "core/base/large_vector.h"
#include "core/base/steps.h"
#include "core/geometry/point.h"
#include "core/plc/edits.h"
#include "core/plc/feature_store.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {

// The index of an edit in its batch; kUntouched: no edit, the feature is as before.
using EditIndex = std::int64_t;
inline constexpr EditIndex kUntouched = -1;
inline constexpr EditIndex kNever = std::numeric_limits<EditIndex>::max();

// A feature of kind kSize, with fields cleared that its shape does not use; -0 becomes +0. Leaves a
// polygon's positions empty.
template <int D>
SizeFeature<D> SizeOf(const Feature& feature);

enum class DraftState : std::uint8_t { kAbsent, kPoint, kSegment, kPolygon, kSize };

template <int D>
class Draft {
 public:
  using State = DraftState;

  // A feature named by the batch, in its final state.
  struct Entry {
    FeatureId id = kNoFeature;
    EditIndex edit = kUntouched;  // the last that names it
    State state = State::kAbsent;
    geometry::Point<D> p{};           // kPoint; -0 is +0
    std::array<FeatureId, 2> ends{};  // kSegment
    bool is_marked = false;           // kSegment: unsplit
    // kPolygon, kSize: as given by the batch; null: as before it.
    const Feature* given = nullptr;
  };

  // `base` and the data of `batch` must outlive the draft and not change. If `steps` stop, the
  // draft is unusable.
  Draft(const FeatureStore<D>& base, const Edits& batch, Steps& steps);

  // The first edit that could not act (kNever if all could), and the reason.
  EditIndex error_edit() const { return error_edit_; }
  const absl::Status& error() const { return error_; }

  // In the order in which the batch first names them.
  const LargeVector<Entry>& entries() const { return entries_; }
  const Entry* Find(FeatureId id) const;
  // The edit to blame for the feature's final state: the last that names it; kUntouched if the
  // batch does not change it.
  EditIndex BlameOf(FeatureId id) const;
  // Is the feature's final state that of before the batch?
  bool IsAsBefore(const Entry& entry) const;

  // Does the batch name a polygon?
  bool has_polygons() const { return has_polygons_; }
  // A polygon or sizing feature of the result that the batch names.
  PolygonFeature PolygonOf(const Entry& entry) const;
  SizeFeature<D> SizeFeatureOf(const Entry& entry) const;

  // The point with that id in the result; null if there is none.
  const geometry::Point<D>* FindPoint(FeatureId id) const;

 private:
  Entry& Touch(FeatureId id, EditIndex edit);
  std::size_t PositionOf(FeatureId id) const;
  absl::Status Act(Edit::Action action, const Feature& feature, Entry& entry) const;
  absl::Status CheckLabelled(Edit::Action action, const Feature& feature, EditIndex edit) const;

  const FeatureStore<D>& base_;
  LargeVector<Entry> entries_;
  // Ascending ids, as in most large batches, need no index.
  bool ascending_ = true;
  bool has_polygons_ = false;
  absl::flat_hash_map<FeatureId, std::size_t> positions_;  // in entries_; empty while ascending_
  EditIndex error_edit_ = kNever;
  absl::Status error_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_DRAFT_H_
