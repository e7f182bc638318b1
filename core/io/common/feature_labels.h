// What a file says of its features beside their geometry: integers (the markers of Triangle and
// TetGen), names, and attributes of points. Plain data.
#ifndef DYNMESH_CORE_IO_COMMON_FEATURE_LABELS_H_
#define DYNMESH_CORE_IO_COMMON_FEATURE_LABELS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::io {

struct FeatureLabels {
  absl::flat_hash_map<FeatureId, std::int64_t> markers;  // nonzero ones
  std::map<FeatureId, std::string> names;                // not empty
  std::size_t attributes = 0;                            // of a point
  std::vector<double> values;                            // of points 1, 2, ...: `attributes` each

  // Is nothing said of any feature?
  bool empty() const { return markers.empty() && names.empty() && attributes == 0; }
  // 0 if the feature has none.
  std::int64_t MarkerOf(FeatureId id) const {
    const auto it = markers.find(id);
    return it == markers.end() ? 0 : it->second;
  }
  // Empty if the feature has none.
  std::string NameOf(FeatureId id) const {
    const auto it = names.find(id);
    return it == names.end() ? "" : it->second;
  }
};

// Numbers pairs of a marker and a name: 0 for none of both, equal numbers for equal pairs, in the
// order of the first question. `labels` outlives it. Not thread-safe.
class LabelNumbers {
 public:
  explicit LabelNumbers(const FeatureLabels& labels) : labels_(labels) {}
  // O(lg n), O(1) without labels.
  std::size_t Of(FeatureId id);

 private:
  const FeatureLabels& labels_;
  std::map<std::pair<std::int64_t, std::string>, std::size_t> numbers_ = {{{0, ""}, 0}};
};

// Gives each of `features` its marker and name as its label. Attributes stay behind. A name may be
// one that a label cannot have: Apply and BuildMesh refuse it. O(n) expected.
void SetLabels(const FeatureLabels& labels, std::vector<Feature>& features);

// Parts of features with ids of their own get the marker and the name of what they are a part of.
// `parts`: (part, whole). O(n lg n) expected.
void KeepLabelsOfParts(const std::vector<std::pair<FeatureId, FeatureId>>& parts,
                       FeatureLabels& labels);

// The markers and names of a mesh's labels. O(n lg n).
FeatureLabels FromLabelColumn(const LabelColumn& labels);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_FEATURE_LABELS_H_
