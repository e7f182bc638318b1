#include "core/plc/labels.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/utf8.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

void SortById(auto& rows) {
  std::ranges::sort(rows, {}, [](const auto& row) { return row.id; });
}

// Null if the name is good.
const char* TroubleOf(std::string_view name) {
  if (name.size() > kMostNameBytes) return "has more than 255 bytes; choose a shorter one";
  while (!name.empty()) {
    char32_t c = 0;
    const std::size_t length = utf8::ReadCharacter(name, &c);
    if (length == 0) return "is not UTF-8; encode it so";
    if (c < 0x20 || (c >= 0x7f && c < 0xa0)) return "has a control character; leave it out";
    name.remove_prefix(length);
  }
  return nullptr;
}

}  // namespace

absl::Status CheckLabel(FeatureId id, const FeatureLabel& label, EditIndex edit) {
  const char* const trouble = TroubleOf(label.name);
  if (trouble == nullptr) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInvalidArgument,
                   absl::StrCat("the name of feature ", id, " ", trouble),
                   {reason::kBadLabel, {id}, static_cast<std::size_t>(edit)});
}

LabelColumn LabelsOf(std::span<const Feature> features) {
  LabelColumn labels;
  for (const Feature& f : features) {
    if (f.label) labels.push_back({f.id, *f.label});
  }
  SortById(labels);
  return labels;
}

LabelColumn RowsOf(const LabelChanges& changes) {
  LabelColumn rows;
  rows.reserve(changes.size());
  for (const LabelChange& change : changes) rows.push_back({change.id, *change.after});
  return rows;
}

LabelChanges LabelTable::ChangesBy(const Edits& batch, Steps& steps) const {
  absl::flat_hash_map<FeatureId, const OptionalLabel*> drafted;
  static const OptionalLabel none;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const Feature& feature = batch.feature(i);
    const Edit::Action action = batch.action(i);
    if (action == Edit::Action::kMove) continue;
    if (action == Edit::Action::kRemove) {
      if (labels_.empty() && drafted.empty()) continue;
      if (steps.Stop()) return {};
      if (drafted.contains(feature.id) || labels_.contains(feature.id)) drafted[feature.id] = &none;
    } else if (feature.label || action == Edit::Action::kSetLabel) {
      if (steps.Stop()) return {};
      drafted[feature.id] = &feature.label;
    }
  }
  LabelChanges changes;
  for (const auto& [id, after] : drafted) {
    if (steps.Stop()) return {};
    OptionalLabel before = Find(id);
    if (before != *after) changes.push_back({id, std::move(before), *after});
  }
  SortById(changes);
  return changes;
}

void LabelTable::Apply(const LabelChanges& changes) {
  for (const LabelChange& change : changes) Put(change.id, change.after);
}

void LabelTable::Undo(const LabelChanges& changes) {
  for (const LabelChange& change : changes) Put(change.id, change.before);
}

LabelColumn LabelTable::All() const {
  LabelColumn all;
  all.reserve(labels_.size());
  for (const auto& [id, label] : labels_) all.push_back({id, label});
  SortById(all);
  return all;
}

void LabelTable::AddTo(std::vector<Feature>& features) const {
  if (labels_.empty()) return;
  for (Feature& f : features) f.label = Find(f.id);
}

std::size_t LabelTable::bytes() const {
  return labels_.capacity() * (sizeof(*labels_.begin()) + 1);
}

// Tables keep the memory of their largest size; an empty one does not.
void LabelTable::Put(FeatureId id, const OptionalLabel& label) {
  if (label) {
    labels_[id] = *label;
    return;
  }
  labels_.erase(id);
  if (labels_.empty()) labels_ = {};
}

OptionalLabel LabelTable::Find(FeatureId id) const {
  const auto it = labels_.find(id);
  return it == labels_.end() ? OptionalLabel() : OptionalLabel(it->second);
}

}  // namespace dynmesh::plc
