// The labels of a script as edits of its batches; see edit_script.h.
#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "core/base/text.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::io {
namespace {

class BatchLabeller {
 public:
  explicit BatchLabeller(const EditScript& script) : script_(script), batches_(script.batches) {
    if (batches_.empty()) batches_.emplace_back();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      for (const Edit& edit : batches_[b].edits) {
        if (edit.action == Edit::Action::kAdd) last_add_[edit.feature.id] = b;
      }
    }
  }

  std::vector<ScriptBatch> Run() {
    for (std::size_t b = 0; b < batches_.size(); ++b) LabelBatch(b);
    return std::move(batches_);
  }

 private:
  void LabelBatch(std::size_t b) {
    const std::map<FeatureId, int> lines = TakeLines(b);
    std::map<FeatureId, std::size_t> adds;  // the edit that leaves the feature there
    ScriptBatch& batch = batches_[b];
    for (std::size_t i = 0; i < batch.edits.size(); ++i) {
      const Edit& edit = batch.edits[i];
      if (edit.action == Edit::Action::kAdd) adds[edit.feature.id] = i;
      if (edit.action == Edit::Action::kRemove) adds.erase(edit.feature.id);
      if (edit.action != Edit::Action::kAdd && edit.action != Edit::Action::kRemove) continue;
      is_there_[edit.feature.id] = edit.action == Edit::Action::kAdd;
    }
    for (const auto& [id, i] : adds) {
      if (const auto it = labels_.find(id); it != labels_.end()) {
        batch.edits[i].feature.label = it->second;
      }
    }
    for (const auto& [id, line] : lines) {
      if (adds.contains(id) || !IsThereAfter(id, b)) continue;
      batch.edits.push_back(Edit::SetLabel(id, labels_.at(id)));
      batch.lines.push_back(line);
    }
  }

  // The features that lines of the batch are about, and the last line of each.
  std::map<FeatureId, int> TakeLines(std::size_t b) {
    std::map<FeatureId, int> lines;
    for (; next_ < script_.label_lines.size(); ++next_) {
      const LabelLine& line = script_.label_lines[next_];
      if (std::min(line.batch, batches_.size() - 1) > b) break;
      labels_[line.id] = line.label;
      lines[line.id] = line.line;
    }
    return lines;
  }

  // A feature that the script does not add is the mesh's. One that it adds later is not there yet.
  bool IsThereAfter(FeatureId id, std::size_t b) const {
    if (const auto it = is_there_.find(id); it != is_there_.end()) return it->second;
    const auto add = last_add_.find(id);
    return add == last_add_.end() || add->second <= b;
  }

  const EditScript& script_;
  std::vector<ScriptBatch> batches_;
  std::map<FeatureId, std::size_t> last_add_;  // the last batch that adds it
  std::map<FeatureId, FeatureLabel> labels_;   // after the lines so far
  std::map<FeatureId, bool> is_there_;         // after the edits so far, of those known
  std::size_t next_ = 0;
};

}  // namespace

std::vector<ScriptBatch> LabelledBatches(const EditScript& script) {
  return script.label_lines.empty() ? script.batches : BatchLabeller(script).Run();
}

std::string FormatLabel(FeatureId id, const FeatureLabel& label) {
  std::string text;
  if (label.marker != 0) text += text::Concat("marker ", id, " ", label.marker, "\n");
  std::string name = label.name;
  for (char& c : name) c = c == '#' || static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  if (name.find_first_not_of(' ') != std::string::npos) {
    text += text::Concat("name ", id, " ", name, "\n");
  }
  return text;
}

}  // namespace dynmesh::io
