#include "core/mesh_data/feature_set.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dynmesh::mesh_data {
namespace {

// Appends what turns `from` into `to`, of the same id: at most a set and an edit of the label.
void AppendChange(const Feature& from, const Feature& to, EditBatch& batch) {
  if (from == to) return;
  Feature relabelled = from;
  relabelled.label = to.label;
  const bool keeps_shape = relabelled == to;
  if (!keeps_shape) batch.push_back(Edit::Set(to));  // with its label, if it has one
  if (from.label != to.label && (keeps_shape || !to.label)) {
    batch.push_back(Edit::SetLabel(to.id, *to.label));
  }
}

}  // namespace

absl::Status FeatureSet::Apply(const EditBatch& batch) {
  for (const Edit& edit : batch) {
    const FeatureId id = edit.feature.id;
    if (edit.action == Edit::Action::kAdd) {
      if (!features_.emplace(id, edit.feature).second) {
        return absl::AlreadyExistsError(absl::StrCat("feature ", id, " is added twice"));
      }
      continue;
    }
    const auto it = features_.find(id);
    if (it == features_.end()) {
      return absl::NotFoundError(absl::StrCat("feature ", id, " is changed, and not there"));
    }
    switch (edit.action) {
      case Edit::Action::kSet: {
        OptionalLabel label = std::move(it->second.label);
        it->second = edit.feature;
        if (!it->second.label) it->second.label = std::move(label);
        break;
      }
      case Edit::Action::kSetLabel:
        it->second.label = edit.feature.label;
        break;
      case Edit::Action::kMove:
        it->second.position = edit.feature.position;
        break;
      default:
        features_.erase(it);
    }
  }
  return absl::OkStatus();
}

std::vector<const Feature*> FeatureSet::Ordered() const {
  // With the ids beside them, a comparison reads no feature.
  std::vector<std::pair<FeatureId, const Feature*>> by_id;
  by_id.reserve(features_.size());
  for (const auto& [id, feature] : features_) by_id.emplace_back(id, &feature);
  std::sort(by_id.begin(), by_id.end());
  std::vector<const Feature*> ordered;
  ordered.reserve(by_id.size());
  for (const auto& [id, feature] : by_id) ordered.push_back(feature);
  return ordered;
}

std::vector<Feature> FeatureSet::Sorted() const {
  std::vector<Feature> sorted;
  sorted.reserve(features_.size());
  for (const Feature* feature : Ordered()) sorted.push_back(*feature);
  return sorted;
}

EditBatch EditsBetween(std::span<const Feature> from, std::span<const Feature> to) {
  EditBatch batch;
  std::size_t i = 0, j = 0;
  while (i < from.size() || j < to.size()) {
    if (j == to.size() || (i < from.size() && from[i].id < to[j].id)) {
      batch.push_back(Edit::Remove(from[i++].id));
    } else if (i == from.size() || to[j].id < from[i].id) {
      batch.push_back(Edit::Add(to[j++]));
    } else {
      AppendChange(from[i++], to[j++], batch);
    }
  }
  return batch;
}

}  // namespace dynmesh::mesh_data
