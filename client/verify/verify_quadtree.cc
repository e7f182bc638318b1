#include "client/verify/verify_quadtree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/feature_kinds.h"
#include "core/io/common/file_writer.h"
#include "dynmesh/quality.h"

namespace dynmesh::cli {
namespace {

using Leaf = io::LeafList::Leaf;

// A cell by its level and its numbers along the axes.
struct Key {
  int level = 0;
  std::array<std::int64_t, 3> at = {0, 0, 0};

  Key Parent() const { return {level - 1, {at[0] >> 1, at[1] >> 1, at[2] >> 1}}; }
  friend bool operator==(const Key&, const Key&) = default;
  template <class H>
  friend H AbslHashValue(H h, const Key& key) {
    return H::combine(std::move(h), key.level, key.at);
  }
};

class Judge {
 public:
  Judge(const io::LeafList& list, QuadtreeReport& report)
      : list_(list), report_(report), axes_(static_cast<std::size_t>(list.dimension)) {}

  void Run(const std::vector<Feature>* features) {
    if (!CheckCells()) return;
    if (CheckCover()) CheckBalance();
    if (features != nullptr) CheckFeatureSizes(*features);
  }

 private:
  static constexpr int kMostLevel = 52;

  VerifyCheck& Begin(const char* name) {
    report_.checks.push_back({name, 0, {}});
    return report_.checks.back();
  }
  static void Fail(VerifyCheck& check, const std::string& example) {
    constexpr std::size_t kExamples = 5;
    ++check.failures;
    if (check.examples.size() < kExamples) check.examples.push_back(example);
  }
  std::string Text(const Leaf& leaf) const {
    std::string text = "the leaf at (";
    for (std::size_t k = 0; k < axes_; ++k) {
      text += (k > 0 ? ", " : "") + io::FormatDouble(leaf.centre[k]);
    }
    return text + ") of side " + io::FormatDouble(leaf.cell.side);
  }
  std::string Text(const Key& key) const {
    std::string text = "cell";
    for (std::size_t k = 0; k < axes_; ++k) text += " " + std::to_string(key.at[k]);
    return text + " of level " + std::to_string(key.level);
  }

  // Finds the root and the key of each leaf. All quotients are exact.
  bool CheckCells() {
    VerifyCheck& check = Begin("cells");
    if (list_.leaves.empty()) {
      Fail(check, "there is no leaf");
      return false;
    }
    const Leaf& first = list_.leaves.front();
    const double side = std::ldexp(first.cell.side, first.cell.level);
    report_.root_side = side;
    for (std::size_t k = 0; k < axes_; ++k) {
      lo_[k] = std::numeric_limits<double>::infinity();
      for (const Leaf& leaf : list_.leaves) {
        lo_[k] = std::min(lo_[k], leaf.centre[k] - leaf.cell.side / 2);
      }
    }
    for (const Leaf& leaf : list_.leaves) {
      Key key{leaf.cell.level, {}};
      bool is_cell =
          leaf.cell.level <= kMostLevel && std::ldexp(leaf.cell.side, leaf.cell.level) == side;
      for (std::size_t k = 0; k < axes_ && is_cell; ++k) {
        const double at = (leaf.centre[k] - lo_[k]) / leaf.cell.side - 0.5;
        is_cell = at == std::floor(at) && at >= 0 && at < std::ldexp(1.0, leaf.cell.level);
        if (is_cell) key.at[k] = static_cast<std::int64_t>(at);
      }
      if (!is_cell) Fail(check, Text(leaf) + " is no cell of the root's grid");
      keys_.push_back(key);
    }
    return check.failures == 0;
  }

  // Joins full cells to their parents, the finest first: at last the root is full.
  bool CheckCover() {
    VerifyCheck& check = Begin("cover");
    std::map<int, std::vector<Key>, std::greater<>> full;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (!leaves_.emplace(keys_[i], i).second) Fail(check, Text(keys_[i]) + " is a leaf twice");
      full[keys_[i].level].push_back(keys_[i]);
    }
    if (check.failures > 0) return false;
    while (!full.empty() && full.begin()->first > 0) {
      absl::flat_hash_map<Key, int> children;
      for (const Key& key : full.begin()->second) ++children[key.Parent()];
      const int level = full.begin()->first - 1;
      full.erase(full.begin());
      for (const auto& [parent, count] : children) {
        inner_.insert(parent);
        full[level].push_back(parent);
        if (count != 1 << axes_) Fail(check, Text(parent) + " is covered in part");
        if (leaves_.contains(parent)) Fail(check, Text(parent) + " is a leaf and has leaves in it");
      }
    }
    return check.failures == 0;
  }

  // A leaf is as fine as those beside it, or half as fine, or finer.
  void CheckBalance() {
    VerifyCheck& check = Begin("balance");
    for (const Key& key : keys_) {
      const std::int64_t end = std::int64_t{1} << key.level;
      const int offsets = axes_ == 2 ? 9 : 27;
      for (int i = 0; i < offsets; ++i) {
        Key beside = key;
        bool is_inside = true;
        for (std::size_t k = 0, rest = static_cast<std::size_t>(i); k < axes_; ++k, rest /= 3) {
          beside.at[k] += static_cast<std::int64_t>(rest % 3) - 1;
          is_inside = is_inside && beside.at[k] >= 0 && beside.at[k] < end;
        }
        if (!is_inside || leaves_.contains(beside) || inner_.contains(beside) ||
            leaves_.contains(beside.Parent())) {
          continue;
        }
        Fail(check, Text(key) + " touches a leaf of four times its side or more");
        break;
      }
    }
  }

  // The leaf that has the position in it; nothing outside.
  std::optional<std::size_t> LeafAt(const std::array<double, 3>& position) const {
    for (const auto& [level, leaves] : report_.leaves_of_level) {
      Key key{level, {}};
      for (std::size_t k = 0; k < axes_; ++k) {
        key.at[k] = static_cast<std::int64_t>(
            std::floor((position[k] - lo_[k]) / std::ldexp(report_.root_side, -level)));
      }
      if (const auto found = leaves_.find(key); found != leaves_.end()) return found->second;
    }
    return std::nullopt;
  }

  // At centres, and at input points: there the local feature size is least.
  void CheckFeatureSizes(const std::vector<Feature>& features) {
    VerifyCheck& check = Begin("lfs");
    std::vector<double> positions;
    std::vector<std::size_t> leaf_of;
    const auto add = [&](const std::array<double, 3>& position, std::size_t leaf) {
      positions.insert(positions.end(), position.begin(),
                       position.begin() + static_cast<std::ptrdiff_t>(axes_));
      leaf_of.push_back(leaf);
    };
    for (std::size_t i = 0; i < list_.leaves.size(); ++i) add(list_.leaves[i].centre, i);
    for (const Feature& f : features) {
      if (!IsPoint(f)) continue;
      if (const auto leaf = LeafAt(f.position)) {
        add(f.position, *leaf);
      } else {
        Fail(check, "point " + std::to_string(f.id) + " is in no leaf");
      }
    }
    const std::vector<double> sizes = LocalFeatureSizes(features, list_.dimension, positions);
    const double most = 4.5 * std::sqrt(list_.dimension);
    double least_ratio = std::numeric_limits<double>::infinity(), greatest_ratio = 0;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      if (!std::isfinite(sizes[i])) continue;
      const Leaf& leaf = list_.leaves[leaf_of[i]];
      const double ratio = sizes[i] / leaf.cell.side;
      least_ratio = std::min(least_ratio, ratio);
      greatest_ratio = std::max(greatest_ratio, ratio);
      if (ratio < 0.25) {
        Fail(check, Text(leaf) + " is too coarse for the local feature size " +
                        io::FormatDouble(sizes[i]));
      }
      if (ratio > most && sizes[i] < report_.root_side) {
        Fail(check,
             Text(leaf) + " is too fine for the local feature size " + io::FormatDouble(sizes[i]));
      }
    }
    if (greatest_ratio > 0) {
      report_.least_ratio = least_ratio;
      report_.greatest_ratio = greatest_ratio;
    }
  }

  const io::LeafList& list_;
  QuadtreeReport& report_;
  const std::size_t axes_;
  std::array<double, 3> lo_ = {0, 0, 0};  // of the root
  std::vector<Key> keys_;                 // by leaf
  absl::flat_hash_map<Key, std::size_t> leaves_;
  absl::flat_hash_set<Key> inner_;
};

}  // namespace

bool QuadtreeReport::Passed() const {
  return std::ranges::all_of(checks, [](const VerifyCheck& c) { return c.failures == 0; });
}

QuadtreeReport VerifyQuadtree(const io::LeafList& list, const std::vector<Feature>* features) {
  QuadtreeReport report;
  report.dimension = list.dimension;
  report.leaves = list.leaves.size();
  report.least_ratio = report.greatest_ratio = std::numeric_limits<double>::quiet_NaN();
  for (const Leaf& leaf : list.leaves) {
    ++report.leaves_of_level[leaf.cell.level];
    report.hash += HashVertex(leaf.centre.data(), list.dimension, list.dimension, kNoFeature);
  }
  Judge(list, report).Run(features);
  return report;
}

}  // namespace dynmesh::cli
