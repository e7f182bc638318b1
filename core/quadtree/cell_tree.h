// The cells that the algorithm has looked at, as a tree: the 2^D children of a cell are a *family*,
// consecutive records. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_CELL_TREE_H_
#define DYNMESH_CORE_QUADTREE_CELL_TREE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/large_vector.h"
#include "core/quadtree/cell.h"
#include "core/quadtree/common_points.h"
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
};

template <int D>
class CellTree {
 public:
  static constexpr int kChildren = Cell<D>::kChildren;
  using Offset = std::array<int, D>;  // in cells of one size, each -1, 0 or 1

  CellTree() { NewFamily(Cell<D>(), kNone); }

  CellRecord& operator[](CellIndex i) { return records_[i]; }
  const CellRecord& operator[](CellIndex i) const { return records_[i]; }

  Cell<D> CellOf(CellIndex i) const {
    return i == kRoot ? Cell<D>() : families_[i >> D].cell.Child(WhichOf(i));
  }
  int LevelOf(CellIndex i) const { return i == kRoot ? 0 : families_[i >> D].cell.level + 1; }
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
    const std::uint32_t family = NewFamily(CellOf(i), i);
    records_[i].family = family;
    MayBeUnused(i);
  }

  // The cell beside i, of its size, or the finest record that contains it: *is_exact says which.
  // kNone outside the root. Expected O(1).
  CellIndex Beside(CellIndex i, const Offset& offset, bool* is_exact) const {
    *is_exact = true;
    return BesideOrAround(i, offset, is_exact);
  }
  // That cell itself; makes it if needed, and those that contain it.
  CellIndex MakeBeside(CellIndex i, const Offset& offset) {
    if (i == kRoot) return IsZero(offset) ? kRoot : kNone;
    const auto [beyond, which] = Step(i, offset);
    if (IsZero(beyond)) return (i >> D) << D | static_cast<CellIndex>(which);
    const CellIndex parent = MakeBeside(ParentOf(i), beyond);
    if (parent == kNone) return kNone;
    MakeChildren(parent);
    return ChildOf(parent, which);
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
      free_.push_back(family);
      if (i != kRoot) unused_.push_back(ParentOf(i));
    }
  }

  std::size_t size() const { return (families_.size() - free_.size() - 1) * kChildren + 1; }
  std::size_t bytes() const {
    return records_.size() * sizeof(CellRecord) + families_.size() * sizeof(Family) +
           (free_.capacity() + unused_.capacity()) * sizeof(CellIndex);
  }

 private:
  struct Family {
    Cell<D> cell;  // whose children they are
    CellIndex parent = kNone;
  };

  static bool IsZero(const Offset& offset) {
    for (const int d : offset) {
      if (d != 0) return false;
    }
    return true;
  }
  struct Stepped {
    Offset beyond;  // from the parent to the parent of the cell beside
    int which;
  };
  static Stepped Step(CellIndex i, const Offset& offset) {
    Stepped step{{}, 0};
    for (int k = 0; k < D; ++k) {
      const int at = (WhichOf(i) >> k & 1) + offset[k];
      step.beyond[k] = at >> 1;  // -1, 0 or 1
      step.which |= (at & 1) << k;
    }
    return step;
  }
  CellIndex BesideOrAround(CellIndex i, const Offset& offset, bool* is_exact) const {
    if (i == kRoot) return IsZero(offset) ? kRoot : kNone;
    const auto [beyond, which] = Step(i, offset);
    if (IsZero(beyond)) return (i >> D) << D | static_cast<CellIndex>(which);
    const CellIndex parent = BesideOrAround(ParentOf(i), beyond, is_exact);
    if (parent == kNone || !*is_exact) return parent;
    if (HasChildren(parent)) return ChildOf(parent, which);
    *is_exact = false;
    return parent;
  }

  std::uint32_t NewFamily(const Cell<D>& cell, CellIndex parent) {
    std::uint32_t family;
    if (free_.empty()) {
      family = static_cast<std::uint32_t>(families_.size());
      families_.push_back({cell, parent});
      for (int which = 0; which < kChildren; ++which) records_.emplace_back();
    } else {
      family = free_.back();
      free_.pop_back();
      families_[family] = {cell, parent};
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
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_CELL_TREE_H_
