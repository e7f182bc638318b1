// The feature set that a batch of edits asks for, as a difference to the one present.
//
// Edits act in order; an edit that cannot (bad id, wrong kind, id in use, unknown
// feature) is the draft's error. Nothing else is validated here. What the batch says
// after its error is not acted, only noted as touched.
// Thread-safe once made. O(batch).
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

// Index of an edit in its batch; kUntouched: no edit, the feature is as it was.
using EditIndex = std::int64_t;
inline constexpr EditIndex kUntouched = -1;
inline constexpr EditIndex kNever = std::numeric_limits<EditIndex>::max();

// A feature of kind kSize without what does not matter to its shape; -0 is +0. A polygon's
// places are left open.
template <int D>
SizeFeature<D> SizeOf(const Feature& feature);

enum class DraftState : std::uint8_t { kAbsent, kPoint, kSegment, kPolygon, kSize };

template <int D>
class Draft {
 public:
  using State = DraftState;

  // A feature that the batch names, as the batch leaves it.
  struct Entry {
    FeatureId id = kNoFeature;
    EditIndex edit = kUntouched;  // the last that names it
    State state = State::kAbsent;
    geometry::Point<D> p{};           // kPoint; -0 is +0
    std::array<FeatureId, 2> ends{};  // kSegment
    // kPolygon, kSize: as the batch has it; null: as before it.
    const Feature* given = nullptr;
  };

  // `base` and what `batch` views must outlive the draft and not change. Where `steps` are stopped,
  // so is this: then it is no draft.
  Draft(const FeatureStore<D>& base, const Edits& batch, Steps& steps);

  // The first edit that could not act, kNever if all could; why.
  EditIndex error_edit() const { return error_edit_; }
  const absl::Status& error() const { return error_; }

  // In the order in which the batch first names them.
  const LargeVector<Entry>& entries() const { return entries_; }
  const Entry* Find(FeatureId id) const;
  // The edit to blame for the feature as it is in the result: the last that names it;
  // kUntouched if that is how it was before the batch.
  EditIndex BlameOf(FeatureId id) const;
  // Is that feature in the result what it was before the batch?
  bool IsAsBefore(const Entry& entry) const;

  // Does the batch name a polygon?
  bool has_polygons() const { return has_polygons_; }
  // A polygon or sizing feature of the resulting set that the batch names.
  PolygonFeature PolygonOf(const Entry& entry) const;
  SizeFeature<D> SizeFeatureOf(const Entry& entry) const;

  // The point with that id in the resulting set, else null.
  const geometry::Point<D>* FindPoint(FeatureId id) const;

 private:
  Entry& Touch(FeatureId id, EditIndex edit);
  std::size_t PositionOf(FeatureId id) const;
  absl::Status Act(Edit::Action action, const Feature& feature, Entry& entry) const;

  const FeatureStore<D>& base_;
  LargeVector<Entry> entries_;
  // Ids that come in ascending order, as in most large batches, need no index.
  bool ascending_ = true;
  bool has_polygons_ = false;
  absl::flat_hash_map<FeatureId, std::size_t> positions_;  // in entries_; else empty
  EditIndex error_edit_ = kNever;
  absl::Status error_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_DRAFT_H_
