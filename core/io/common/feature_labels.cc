#include "core/io/common/feature_labels.h"

namespace dynmesh::io {

std::size_t LabelNumbers::Of(FeatureId id) {
  if (labels_.markers.empty() && labels_.names.empty()) return 0;
  return numbers_.try_emplace({labels_.MarkerOf(id), labels_.NameOf(id)}, numbers_.size())
      .first->second;
}

void SetLabels(const FeatureLabels& labels, std::vector<Feature>& features) {
  if (labels.markers.empty() && labels.names.empty()) return;
  for (Feature& f : features) f.label = {labels.MarkerOf(f.id), labels.NameOf(f.id)};
}

void KeepLabelsOfParts(const std::vector<std::pair<FeatureId, FeatureId>>& parts,
                       FeatureLabels& labels) {
  for (const auto& [part, whole] : parts) {
    if (const std::int64_t marker = labels.MarkerOf(whole); marker != 0) {
      labels.markers[part] = marker;
    }
    if (const std::string name = labels.NameOf(whole); !name.empty()) labels.names[part] = name;
  }
}

FeatureLabels FromLabelColumn(const LabelColumn& labels) {
  FeatureLabels result;
  for (const auto& [id, label] : labels) {
    if (label.marker != 0) result.markers[id] = label.marker;
    if (!label.name.empty()) result.names[id] = label.name;
  }
  return result;
}

}  // namespace dynmesh::io
