// The labels of the features present, and their changes by a batch.
//
// Kept beside the features, which are far more than labels in most meshes: nothing is kept for a
// feature without a label, and a batch without labels on features without labels costs a look at
// each edit. The labels after a batch are a function of the labels before and the batch, and after
// a history a function of what its edits left: as the features are.
//
// Thread-compatible.
#ifndef DYNMESH_CORE_PLC_LABELS_H_
#define DYNMESH_CORE_PLC_LABELS_H_

#include <cstddef>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "core/base/steps.h"
#include "core/plc/draft.h"
#include "core/plc/edits.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::plc {

// OK if the name of `label` is as FeatureLabel demands. INVALID_ARGUMENT (BAD_LABEL).
absl::Status CheckLabel(FeatureId id, const FeatureLabel& label, EditIndex edit);

// The labels of `features`, which have different ids.
LabelColumn LabelsOf(std::span<const Feature> features);

// What a batch makes of the labels. Ascending ids; no label stays as it is.
struct LabelChange {
  FeatureId id = kNoFeature;
  OptionalLabel before, after;
  friend bool operator==(const LabelChange&, const LabelChange&) = default;
};
using LabelChanges = std::vector<LabelChange>;

// The rows of MeshDiff::labels.
LabelColumn RowsOf(const LabelChanges& changes);

class LabelTable {
 public:
  // The net change by `batch`, whose edits can act (draft.h). O(edits), and O(lg n) for each of n
  // labels that may change. If `steps` stop, the result is unspecified.
  LabelChanges ChangesBy(const Edits& batch, Steps& steps) const;

  // REQUIRES: the changes are those of a batch on these labels.
  void Apply(const LabelChanges& changes);
  // Undoes them. REQUIRES: they were applied last.
  void Undo(const LabelChanges& changes);

  // All, by id. O(n lg n).
  LabelColumn All() const;
  // Gives its label to each of `features`. O(features) if there are labels.
  void AddTo(std::vector<Feature>& features) const;

  bool empty() const { return labels_.empty(); }
  std::size_t bytes() const;  // approximate

 private:
  void Put(FeatureId id, const OptionalLabel& label);
  OptionalLabel Find(FeatureId id) const;

  absl::flat_hash_map<FeatureId, FeatureLabel> labels_;  // none is empty
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_LABELS_H_
