#include "core/mesh_data/labels.h"

#include <algorithm>
#include <functional>

namespace dynmesh::mesh_data {
namespace {

// Merges two columns. Calls first(row), second(row), or both(row of each) for each id in order.
template <class First, class Second, class Both>
void Merge(const LabelColumn& a, const LabelColumn& b, First first, Second second, Both both) {
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->id < j->id)) {
      first(*i++);
    } else if (i == a.end() || j->id < i->id) {
      second(*j++);
    } else {
      both(*i++, *j++);
    }
  }
}

}  // namespace

bool AreLabels(const LabelColumn& labels) {
  return (labels.empty() || labels.front().id != kNoFeature) &&
         std::ranges::adjacent_find(labels, std::ranges::greater_equal(), &LabelOfFeature::id) ==
             labels.end();
}

bool AreLabelsOfMesh(const LabelColumn& labels) {
  const auto is_empty = [](const LabelOfFeature& row) { return row.label.empty(); };
  return AreLabels(labels) && std::ranges::none_of(labels, is_empty);
}

LabelColumn ChangedLabels(const LabelColumn& labels, const LabelColumn& changes) {
  if (changes.empty()) return labels;
  LabelColumn result;
  result.reserve(labels.size() + changes.size());
  const auto add = [&](const LabelOfFeature& row) {
    if (!row.label.empty()) result.push_back(row);
  };
  Merge(labels, changes, add, add,
        [&](const LabelOfFeature&, const LabelOfFeature& change) { add(change); });
  return result;
}

LabelColumn DiffLabels(const LabelColumn& from, const LabelColumn& to) {
  LabelColumn diff;
  Merge(
      from, to,
      [&](const LabelOfFeature& gone) {
        diff.push_back({gone.id, {}});
      },
      [&](const LabelOfFeature& come) { diff.push_back(come); },
      [&](const LabelOfFeature& before, const LabelOfFeature& after) {
        if (before != after) diff.push_back(after);
      });
  return diff;
}

std::size_t ByteSize(const LabelColumn& labels) {
  std::size_t bytes = labels.size() * sizeof(LabelOfFeature);
  for (const LabelOfFeature& row : labels) bytes += row.label.name.size();
  return bytes;
}

}  // namespace dynmesh::mesh_data
