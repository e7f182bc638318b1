// Random labels for random scripts.
#ifndef DYNMESH_TESTS_SUPPORT_LABEL_SCRIPT_H_
#define DYNMESH_TESTS_SUPPORT_LABEL_SCRIPT_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"
#include "tests/support/workload.h"

namespace dynmesh::test {

// Of few values, so that two are often the same; some are empty.
inline FeatureLabel RandomLabel(Random& random) {
  static const char* const kNames[] = {"", "", "Inlet", "W\xc3\xa4nde"};
  return {random.Below(3) - 1, kNames[random.Below(4)]};
}

// `batch`, some of its edits with labels, and edits of labels before, between and behind them.
inline EditBatch WithLabels(const EditBatch& batch, const std::vector<Feature>& present,
                            Random& random) {
  EditBatch labelled;
  for (int i = random.Below(3); i > 0 && !present.empty(); --i) {
    const auto row = static_cast<std::size_t>(random.Below(static_cast<int>(present.size())));
    labelled.push_back(Edit::SetLabel(present[row].id, RandomLabel(random)));
  }
  for (Edit edit : batch) {
    const bool may = edit.action == Edit::Action::kAdd || edit.action == Edit::Action::kSet;
    if (may && random.OneIn(2)) edit.feature.label = RandomLabel(random);
    labelled.push_back(edit);
    if (edit.action != Edit::Action::kRemove && random.OneIn(4)) {
      labelled.push_back(Edit::SetLabel(edit.feature.id, RandomLabel(random)));
    }
  }
  return labelled;
}

// Another script with labels.
template <class Script>
class LabelledScript {
 public:
  LabelledScript(Script script, std::uint64_t seed) : script_(std::move(script)), random_(seed) {}

  EditBatch Next(const std::vector<Feature>& present) {
    return WithLabels(script_.Next(present), present, random_);
  }

 private:
  Script script_;
  Random random_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_LABEL_SCRIPT_H_
