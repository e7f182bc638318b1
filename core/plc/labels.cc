#include "core/plc/labels.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {
namespace {

void SortById(auto& rows) {
  std::ranges::sort(rows, {}, [](const auto& row) { return row.id; });
}

// Reads one character. 0 if the bytes are no character of UTF-8 (surrogates and longer forms than
// needed are none). REQUIRES: `text` is not empty.
std::size_t ReadCharacter(std::string_view text, char32_t& character) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xc2 ? 0
                             : first < 0xe0 ? 2
                             : first < 0xf0 ? 3
                             : first < 0xf5 ? 4
                                            : 0;
  if (length == 0 || length > text.size()) return 0;
  constexpr char32_t kBitsOfFirst[] = {0, 0x7f, 0x1f, 0x0f, 0x07};
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  character = first & kBitsOfFirst[length];
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    character = character << 6 | (byte(i) & 0x3f);
  }
  const bool is_surrogate = character >= 0xd800 && character < 0xe000;
  return character < kLeast[length] || is_surrogate || character > 0x10ffff ? 0 : length;
}

// Null if the name is good.
const char* TroubleOf(std::string_view name) {
  if (name.size() > kMostNameBytes) return "has more than 255 bytes; choose a shorter one";
  while (!name.empty()) {
    char32_t c = 0;
    const std::size_t length = ReadCharacter(name, c);
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
