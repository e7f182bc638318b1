// The cells that the algorithm has looked at, as a tree: the 2^D children of a cell are a *family*,
// consecutive records. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_CELL_TREE_H_
#define DYNMESH_CORE_QUADTREE_CELL_TREE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/large_vector.h"
#include "core/quadtree/cell.h"
#include "core/quadtree/common_points.h"
#include "core/quadtree/offsets.h"
#include "core/sac/epoch_order.h"

namespace dynmesh::quadtree {

// A record; stays the same while the record is in the tree. 0 is the root.
using CellIndex = std::uint32_t;
inline constexpr CellIndex kRoot = 0;

struct CellRecord {
  std::uint32_t family = kNone;  // of its children
  sac::OpId operations = sac::kNoOp;
  // Of FeatureTree.
  PackedPoints common;
  std::uint32_t list = kNone;
  bool is_open : 1 = false;
  // Of BuildQt.
  bool is_crowded : 1 = false;
  bool is_split : 1 = false;
  bool was_split : 1 = false;   // when changes were last taken
  bool is_changed : 1 = false;  // stands in the list of changes
  bool is_graded : 1 = false;   // without a trace: Grade was requested
};

template <int D>
class CellTree {
 public:
  static constexpr int kChildren = Cell<D>::kChildren;

  CellTree() {
    families_.emplace_back();
    records_.resize(kChildren);
  }

  CellRecord& operator[](CellIndex i) { return records_[i]; }
  const CellRecord& operator[](CellIndex i) const { return records_[i]; }

  Cell<D> CellOf(CellIndex i) const {
    if (i == kRoot) return {};
    const Family& family = families_[i >> D];
    return Cell<D>{family.level, family.at}.Child(WhichOf(i));
  }
  int LevelOf(CellIndex i) const { return i == kRoot ? 0 : families_[i >> D].level + 1; }
  // CellOf(i).Morton()
  std::uint64_t MortonOf(CellIndex i) const {
    if (i == kRoot) return 0;
    const Family& family = families_[i >> D];
    return Cell<D>::MortonOfChild(family.morton, family.level, WhichOf(i));
  }
  // REQUIRES: not the root.
  CellIndex ParentOf(CellIndex i) const { return families_[i >> D].parent; }
  static int WhichOf(CellIndex i) { return static_cast<int>(i & (kChildren - 1)); }
  // REQUIRES: it has children.
  CellIndex ChildOf(CellIndex i, int which) const {
    return records_[i].family << D | static_cast<CellIndex>(which);
  }
  bool HasChildren(CellIndex i) const { return records_[i].family != kNone; }
  void MakeChildren(CellIndex i) {
    if (HasChildren(i)) return;
    const std::uint32_t family = NewFamily(i);
    records_[i].family = family;
    MayBeUnused(i);
  }

  // A cell, or the finest record that contains it; kNone outside the root.
  struct Found {
    CellIndex cell = kNone;
    bool is_exact = false;
  };
  using Block = std::array<Found, Offsets<D>::kCount>;  // by offset
  // The cells of i's size that touch it. The reference is valid until the tree changes, or the next
  // call. O(1) if the last call was for i, one of its siblings or a child; else O(depth).
  const Block& BlockAround(CellIndex i) {
    const int level = LevelOf(i);
    Around& around = around_[static_cast<std::size_t>(level)];
    if (level < known_levels_ && around.cell == i) return around.block;
    if (i == kRoot) {
      around.block[Offsets<D>::kNone] = {kRoot, true};
    } else {
      const Block& parents = BlockAround(ParentOf(i));
      for (std::size_t k = 0; k < around.block.size(); ++k) {
        around.block[k] = BesideChild(parents, WhichOf(i), k);
      }
    }
    around.cell = i;
    known_levels_ = level + 1;
    return around.block;
  }
  // The cell beside child `which` of the cell in the block's middle.
  Found BesideChild(const Block& block, int which, std::size_t offset) const {
    const auto step = Offsets<D>::kSteps[static_cast<std::size_t>(which)][offset];
    const Found parent = block[step.between_parents];
    if (!parent.is_exact) return parent;
    if (!HasChildren(parent.cell)) return {parent.cell, false};
    return {ChildOf(parent.cell, step.which), true};
  }
  // The cell beside i; makes it if needed, and those that contain it. kNone outside the root.
  CellIndex MakeBeside(CellIndex i, std::size_t offset) {
    const Found found = BlockAround(i)[offset];
    if (found.is_exact || found.cell == kNone) return found.cell;
    const auto step = Offsets<D>::kSteps[static_cast<std::size_t>(WhichOf(i))][offset];
    const CellIndex parent = MakeBeside(ParentOf(i), step.between_parents);
    MakeChildren(parent);
    return ChildOf(parent, step.which);
  }

  // The children of i may have become unused.
  void MayBeUnused(CellIndex i) { unused_.push_back(i); }
  // Frees families of which nothing is known. Call between propagations. Amortised O(1) for each
  // call of the two above.
  void FreeUnused() {
    // A family may become unused after those below it.
    while (!unused_.empty()) {
      const CellIndex i = unused_.back();
      unused_.pop_back();
      const CellRecord& r = records_[i];
      const std::uint32_t family = r.family;
      if (family == kNone || r.is_open || IsOrWasSplit(r) || IsUsed(family)) continue;
      records_[i].family = kNone;
      families_[family].parent = kNone;
      known_levels_ = std::min(known_levels_, LevelOf(i) + 1);
      free_.push_back(family);
      if (i != kRoot) unused_.push_back(ParentOf(i));
    }
  }

  std::size_t size() const { return (families_.size() - free_.size() - 1) * kChildren + 1; }
  std::size_t bytes() const {
    return sizeof(*this) + records_.size() * sizeof(CellRecord) +
           families_.size() * sizeof(Family) +
           (free_.capacity() + unused_.capacity()) * sizeof(CellIndex);
  }

 private:
  // Level, index, place and Morton() of the cell whose children they are.
  struct Family {
    int level = 0;
    CellIndex parent = kNone;
    std::array<std::uint64_t, D> at = {};
    std::uint64_t morton = 0;
  };

  // The block around a cell, as long as its level is below known_levels_.
  struct Around {
    CellIndex cell = kNone;
    Block block;
  };

  // Of the children of `parent`.
  std::uint32_t NewFamily(CellIndex parent) {
    const Cell<D> cell = CellOf(parent);
    const Family made = {cell.level, parent, cell.at, MortonOf(parent)};
    // Finer blocks may have cells in them that contained the new ones.
    known_levels_ = std::min(known_levels_, cell.level + 1);
    std::uint32_t family;
    if (free_.empty()) {
      family = static_cast<std::uint32_t>(families_.size());
      families_.push_back(made);
      records_.resize(records_.size() + kChildren);
    } else {
      family = free_.back();
      free_.pop_back();
      families_[family] = made;
    }
    return family;
  }
  static bool IsOrWasSplit(const CellRecord& r) {
    return r.is_split || r.was_split || r.is_changed;
  }
  bool IsUsed(std::uint32_t family) const {
    for (int which = 0; which < kChildren; ++which) {
      const CellRecord& r = records_[family << D | static_cast<CellIndex>(which)];
      if (r.family != kNone || r.is_open || IsOrWasSplit(r) || r.operations != sac::kNoOp) {
        return true;
      }
    }
    return false;
  }

  LargeVector<CellRecord> records_;
  LargeVector<Family> families_;  // by family; 0 is of the root alone
  std::vector<std::uint32_t> free_;
  std::vector<CellIndex> unused_;
  std::array<Around, kMostLevel + 1> around_;  // by level
  int known_levels_ = 0;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_CELL_TREE_H_
