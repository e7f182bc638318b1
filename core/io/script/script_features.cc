#include "core/io/script/script_features.h"

#include <utility>

#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::io {
namespace {

using text::Concat;

class ScriptState {
 public:
  absl::Status Apply(const Edit& edit, const std::string& where) {
    const FeatureId id = edit.feature.id;
    const auto it = features_.find(id);
    const bool present = it != features_.end();
    if (edit.action == Edit::Action::kAdd) {
      if (present) return Error(where, Concat("feature ", id, " is there already: use set"));
      features_[id] = {edit.feature, where};
      return absl::OkStatus();
    }
    if (!present) return Error(where, Concat("there is no feature ", id));
    if (edit.action == Edit::Action::kRemove) {
      features_.erase(it);
      return absl::OkStatus();
    }
    if (edit.action == Edit::Action::kMove && !IsPoint(it->second.first)) {
      return Error(where, Concat("feature ", id, " is no point: it cannot be moved"));
    }
    it->second = {edit.feature, where};
    return absl::OkStatus();
  }

  ScriptFeatures Finish() && {
    ScriptFeatures result;
    for (auto& [id, entry] : features_) {
      result.features.push_back(std::move(entry.first));
      result.places.emplace(id, std::move(entry.second));
    }
    return result;
  }

 private:
  static absl::Status Error(const std::string& where, const std::string& message) {
    return absl::InvalidArgumentError(Concat(where, ": ", message));
  }

  std::map<FeatureId, std::pair<Feature, std::string>> features_;
};

}  // namespace

absl::StatusOr<ScriptFeatures> FeaturesAfter(const EditScript& script) {
  ScriptState state;
  for (std::size_t b = 0; b < script.batches.size(); ++b) {
    const ScriptBatch& batch = script.batches[b];
    for (std::size_t e = 0; e < batch.edits.size(); ++e) {
      if (auto s = state.Apply(batch.edits[e], script.Where(b, e)); !s.ok()) return s;
    }
  }
  return std::move(state).Finish();
}

}  // namespace dynmesh::io
