// The cells that the algorithm has looked at, with what is known of each. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_CELL_TABLE_H_
#define DYNMESH_CORE_QUADTREE_CELL_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/quadtree/cell.h"
#include "core/quadtree/common_points.h"
#include "core/sac/epoch_order.h"

namespace dynmesh::quadtree {

// A cell of the table; stays the same while the cell is in it.
using CellIndex = std::uint32_t;

template <int D>
struct CellRecord {
  Cell<D> cell;
  // Of FeatureTree.
  CommonPoints common;               // of the features that meet the cell
  std::vector<ShapeIndex> features;  // those, if the record is a leaf of the feature tree
  bool is_listed = false;            // it is in the feature tree
  bool is_open = false;              // and not a leaf there
  // Of BuildQt.
  bool is_crowded = false;
  bool is_split = false;
  bool was_split = false;   // when changes were last taken
  bool is_changed = false;  // stands in the list of changes
  sac::OpId operations = sac::kNoOp;
};

template <int D>
class CellTable {
 public:
  CellRecord<D>& operator[](CellIndex i) { return records_[i]; }
  const CellRecord<D>& operator[](CellIndex i) const { return records_[i]; }

  // kNone if it is not there. Expected O(1), as all.
  CellIndex Find(const Cell<D>& cell) const {
    const auto it = index_.find(cell);
    return it == index_.end() ? kNone : it->second;
  }
  CellIndex FindOrAdd(const Cell<D>& cell) {
    const auto [it, is_new] = index_.try_emplace(cell, kNone);
    if (!is_new) return it->second;
    if (free_.empty()) {
      it->second = static_cast<CellIndex>(records_.size());
      records_.emplace_back().cell = cell;
    } else {
      it->second = free_.back();
      free_.pop_back();
      records_[it->second].cell = cell;
    }
    unused_.push_back(it->second);
    return it->second;
  }
  // The record may have become unused.
  void MayBeUnused(CellIndex i) { unused_.push_back(i); }
  // Frees records that are in no tree and have no operation. Call between propagations. Amortised
  // O(1) for each call of the two above.
  void FreeUnused() {
    for (const CellIndex i : unused_) {
      CellRecord<D>& r = records_[i];
      if (r.is_listed || r.is_split || r.is_changed || r.operations != sac::kNoOp) continue;
      const auto it = index_.find(r.cell);
      if (it == index_.end() || it->second != i) continue;  // freed before
      index_.erase(it);
      r = {};
      free_.push_back(i);
    }
    unused_.clear();
  }

  std::size_t size() const { return records_.size() - free_.size(); }
  std::size_t bytes() const {
    return records_.capacity() * sizeof(CellRecord<D>) +
           index_.capacity() * (sizeof(*index_.begin()) + 1) +
           (free_.capacity() + unused_.capacity()) * sizeof(CellIndex);
  }

 private:
  std::vector<CellRecord<D>> records_;
  absl::flat_hash_map<Cell<D>, CellIndex> index_;
  std::vector<CellIndex> free_, unused_;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_CELL_TABLE_H_
