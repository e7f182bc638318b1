// Which features meet which cells. A leaf of this tree keeps a list of the features that meet it,
// an inner cell only what its features have in common. Cells that no feature meets are not in it.
//
// All answers are functions of the features and the grid; how far the tree is open does not affect
// them. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_
#define DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/quadtree/cell.h"
#include "core/quadtree/cell_table.h"
#include "core/quadtree/common_points.h"
#include "core/quadtree/shape.h"

namespace dynmesh::quadtree {

template <int D>
class FeatureTree {
 public:
  using Key = Cell<D>;
  using Record = CellRecord<D>;
  // By ShapeIndex.
  using Shapes = std::vector<Shape<D>>;

  // Both must outlive this. The root is in the tree from the beginning.
  FeatureTree(const Grid<D>& grid, CellTable<D>& cells, const Shapes& shapes)
      : grid_(grid), cells_(cells), shapes_(shapes), root_(cells.FindOrAdd(Key())) {
    cells_[root_].is_listed = true;
  }

  CellIndex root() const { return root_; }

  // The cost of both: the open cells that the feature meets, and the lists of leaves among them.
  void Add(ShapeIndex shape) { AddIn(root_, shape); }
  void Remove(ShapeIndex shape) { RemoveIn(root_, shape); }

  // Is the cell crowded? It is met by a feature, and with those that meet some cell of its block
  // (the cells of its size that touch it) these features have no point in common.
  // If a cell is crowded, its parent is (Lemma 4.1.1). O(3^D).
  bool IsCrowded(CellIndex i) const {
    const Record& r = cells_[i];
    if (!r.common.has_features() || r.cell.level >= grid_.most_level()) return false;
    if (r.common.are_apart()) return true;
    return !ForEachTouching(r.cell, [&](const Key& other) {
      return other == r.cell || !r.common.AreApartFrom(CommonIn(other), shapes_);
    });
  }

  // Gives a leaf's list to its children.
  void Open(CellIndex i) {
    cells_[i].is_open = true;
    const std::vector<ShapeIndex> features = std::exchange(cells_[i].features, {});
    for (const ShapeIndex shape : features) AddInChildren(i, shape);
  }
  // Takes the lists of its children, which leave the tree.
  void Close(CellIndex i) {
    if (!cells_[i].is_open) return;
    cells_[i].is_open = false;
    std::vector<ShapeIndex> features;
    for (int which = 0; which < Key::kChildren; ++which) {
      const CellIndex child = cells_.Find(cells_[i].cell.Child(which));
      if (child == kNone || !cells_[child].is_listed) continue;
      Close(child);
      Record& c = cells_[child];
      features.insert(features.end(), c.features.begin(), c.features.end());
      Leave(child);
    }
    std::sort(features.begin(), features.end());
    features.erase(std::unique(features.begin(), features.end()), features.end());
    cells_[i].features = std::move(features);
  }

  // Cells that no feature meets any more leave the tree. Until then they stay open: operations on
  // them and below may be kept, if other features come.
  void ForgetEmpty() {
    for (const CellIndex i : emptied_) {
      if (!cells_[i].is_listed || cells_[i].common.has_features()) continue;
      Close(i);
      Leave(i);
    }
    emptied_.clear();
  }

  // The child of an open cell, if a feature meets it; else kNone.
  CellIndex ChildOf(CellIndex i, int which) const {
    const CellIndex child = cells_.Find(cells_[i].cell.Child(which));
    return child != kNone && cells_[child].common.has_features() ? child : kNone;
  }

  // Calls f(i) for the cells i of the tree whose block the feature meets.
  template <class F>
  void ForEachNear(ShapeIndex shape, F f) const {
    ForEachNearIn(root_, shape, f);
  }

 private:
  bool Meets(ShapeIndex shape, const Key& cell) const {
    return shapes_[shape].Meets(grid_.BoxOf(cell));
  }

  void AddIn(CellIndex i, ShapeIndex shape) {
    cells_[i].common.Add(shape, shapes_);
    if (cells_[i].is_open) {
      AddInChildren(i, shape);
    } else {
      cells_[i].features.push_back(shape);
    }
  }
  void AddInChildren(CellIndex i, ShapeIndex shape) {
    const Key cell = cells_[i].cell;
    for (int which = 0; which < Key::kChildren; ++which) {
      const Key key = cell.Child(which);
      if (!Meets(shape, key)) continue;
      const CellIndex child = cells_.FindOrAdd(key);
      cells_[child].is_listed = true;
      AddIn(child, shape);
    }
  }

  void RemoveIn(CellIndex i, ShapeIndex shape) {
    CommonPoints common;
    if (cells_[i].is_open) {
      const Key cell = cells_[i].cell;
      for (int which = 0; which < Key::kChildren; ++which) {
        const CellIndex child = ChildOf(i, which);
        if (child == kNone) continue;
        if (Meets(shape, cell.Child(which))) {
          RemoveIn(child, shape);
          if (!cells_[child].common.has_features()) emptied_.push_back(child);
        }
        common.Add(cells_[child].common, shapes_);
      }
    } else {
      std::vector<ShapeIndex>& features = cells_[i].features;
      const auto it = std::find(features.begin(), features.end(), shape);
      *it = features.back();
      features.pop_back();
      // With fewer features they have more in common, never less.
      const CommonPoints& before = cells_[i].common;
      for (const ShapeIndex left : features) {
        common.Add(left, shapes_);
        if (common == before) break;
      }
    }
    cells_[i].common = std::move(common);
  }

  void Leave(CellIndex i) {
    Record& r = cells_[i];
    r.is_listed = false;
    r.features = {};
    r.common = {};
    cells_.MayBeUnused(i);
  }

  // Of the features that meet the cell, whether it is in the tree or not.
  CommonPoints CommonIn(const Key& cell) const {
    CellIndex i = cells_.Find(cell);
    if (i != kNone && cells_[i].is_listed) return cells_[i].common;
    Key around = cell;
    do {
      around = around.Parent();
      i = cells_.Find(around);
    } while (i == kNone || !cells_[i].is_listed);
    CommonPoints common;
    if (cells_[i].is_open) return common;
    for (const ShapeIndex shape : cells_[i].features) {
      if (MeetsDownTo(shape, around, cell)) common.Add(shape, shapes_);
      if (common.are_apart()) break;
    }
    return common;
  }
  // As if all cells from `around` down to `cell` were open.
  bool MeetsDownTo(ShapeIndex shape, const Key& around, Key cell) const {
    for (; cell.level > around.level; cell = cell.Parent()) {
      if (!Meets(shape, cell)) return false;
    }
    return true;
  }

  template <class F>
  void ForEachNearIn(CellIndex i, ShapeIndex shape, F f) const {
    const Key& cell = cells_[i].cell;
    if (cell.level > 0 && !shapes_[shape].Meets(grid_.BlockOf(cell))) return;
    f(i);
    if (!cells_[i].is_open) return;
    for (int which = 0; which < Key::kChildren; ++which) {
      const CellIndex child = ChildOf(i, which);
      if (child != kNone) ForEachNearIn(child, shape, f);
    }
  }

  const Grid<D>& grid_;
  CellTable<D>& cells_;
  const Shapes& shapes_;
  CellIndex root_;
  std::vector<CellIndex> emptied_;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_
