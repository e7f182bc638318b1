// Which features meet which cells. A cell of this tree is *open*, with children in it, or a leaf
// with a list of the features that meet it; of an open cell only what these have in common is kept.
//
// All answers are functions of the features and the grid: which cells are open does not affect
// them. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_
#define DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/quadtree/cell.h"
#include "core/quadtree/cell_tree.h"
#include "core/quadtree/common_points.h"
#include "core/quadtree/list_pool.h"
#include "core/quadtree/shape.h"

namespace dynmesh::quadtree {

template <int D>
class FeatureTree {
 public:
  // By ShapeIndex.
  using Shapes = std::vector<Shape<D>>;

  // All must outlive this.
  FeatureTree(const Grid<D>& grid, CellTree<D>& cells, const Shapes& shapes)
      : grid_(grid), cells_(cells), shapes_(shapes) {}

  // The cost of both: the open cells that the feature meets, and the lists of leaves among them.
  void Add(ShapeIndex shape) { AddIn(kRoot, shape); }
  void Remove(ShapeIndex shape) { RemoveIn(kRoot, shape); }

  // Is the cell crowded? It is met by a feature, and with those that meet some cell of its block
  // (the cells of its size that touch it) these features have no point in common.
  // If a cell is crowded, its parent is (Lemma 4.1.1). O(3^D). REQUIRES: its parent is open.
  bool IsCrowded(CellIndex i) const {
    const PackedPoints& packed = cells_[i].common;
    if (!packed.has_features() || cells_.LevelOf(i) >= grid_.most_level()) return false;
    if (packed.b == PackedPoints::kApart) return true;
    const CommonPoints own = CommonOf(i);
    typename CellTree<D>::Offset offset;
    offset.fill(-1);
    // Counts from (-1, ..., -1) to (1, ..., 1).
    for (int k = 0; k < D;) {
      if (IsApartFrom(own, i, offset)) return true;
      for (k = 0; k < D && ++offset[k] > 1; ++k) offset[k] = -1;
    }
    return false;
  }

  // Gives a leaf's list to its children.
  void Open(CellIndex i) {
    cells_.MakeChildren(i);
    const std::vector<ShapeIndex> features = TakeFeatures(i);
    cells_[i].is_open = true;
    for (const ShapeIndex shape : features) AddInChildren(i, shape);
  }
  // Takes the lists of its children.
  void Close(CellIndex i) {
    if (!cells_[i].is_open) return;
    cells_[i].is_open = false;
    std::vector<ShapeIndex> features;
    for (int which = 0; which < Cell<D>::kChildren; ++which) {
      const CellIndex child = cells_.ChildOf(i, which);
      Close(child);
      const auto of_child = TakeFeatures(child);
      features.insert(features.end(), of_child.begin(), of_child.end());
      SetCommon(child, {});
    }
    std::sort(features.begin(), features.end());
    features.erase(std::unique(features.begin(), features.end()), features.end());
    if (features.size() > 1) cells_[i].list = lists_.Add(std::move(features));
    cells_.MayBeUnused(i);
  }

  // Closes cells that no feature meets any more. Until then they stay open: operations on them and
  // below may be kept, if other features come.
  void CloseEmpty() {
    for (const CellIndex i : emptied_) {
      if (!cells_[i].common.has_features()) Close(i);
    }
    emptied_.clear();
  }

  // Bit i: a feature meets child i. REQUIRES: the cell is open.
  std::uint32_t ChildrenMet(CellIndex i) const {
    std::uint32_t met = 0;
    for (int which = 0; which < Cell<D>::kChildren; ++which) {
      if (cells_[cells_.ChildOf(i, which)].common.has_features()) met |= 1u << which;
    }
    return met;
  }

  // Calls f(i) for the cells i that a feature meets, with an open parent, whose block this feature
  // meets.
  template <class F>
  void ForEachNear(ShapeIndex shape, F f) const {
    ForEachNearIn(kRoot, Cell<D>(), shape, f);
  }

  std::size_t bytes() const { return lists_.bytes() + many_.bytes(); }

 private:
  using Key = Cell<D>;

  bool Meets(ShapeIndex shape, const Key& cell) const {
    return shapes_[shape].Meets(grid_.BoxOf(cell));
  }

  CommonPoints CommonOf(CellIndex i) const {
    const PackedPoints& packed = cells_[i].common;
    const bool has_many = packed.b == PackedPoints::kMany;
    return CommonPoints::Of(packed, has_many ? std::span<const PointIndex>(many_[packed.a])
                                             : std::span<const PointIndex>());
  }
  void SetCommon(CellIndex i, const CommonPoints& common) {
    PackedPoints& packed = cells_[i].common;
    if (packed.b == PackedPoints::kMany) many_.Take(&packed.a);
    packed = common.Packed();
    if (packed.b == PackedPoints::kMany) {
      packed.a = many_.Add({common.many().begin(), common.many().end()});
    }
  }

  // Of a leaf.
  std::span<const ShapeIndex> FeaturesOf(CellIndex i) const {
    const CellRecord& r = cells_[i];
    if (r.list != kNone) return lists_[r.list];
    if (r.common.is_lone()) return std::span(&r.common.a, 1);
    return {};
  }
  std::vector<ShapeIndex> TakeFeatures(CellIndex i) {
    const auto features = FeaturesOf(i);
    std::vector<ShapeIndex> taken(features.begin(), features.end());
    lists_.Take(&cells_[i].list);
    return taken;
  }

  void AddIn(CellIndex i, ShapeIndex shape) {
    const PackedPoints before = cells_[i].common;
    if (!before.has_features()) {
      cells_[i].common = {shape, PackedPoints::kLone};
    } else if (before.b != PackedPoints::kApart) {
      CommonPoints common = CommonOf(i);
      common.Add(shape, shapes_);
      SetCommon(i, common);
    }
    if (cells_[i].is_open) return AddInChildren(i, shape);
    std::uint32_t& list = cells_[i].list;
    if (list != kNone) {
      lists_[list].push_back(shape);
    } else if (before.is_lone()) {
      list = lists_.Add({before.a, shape});
    }
  }
  void AddInChildren(CellIndex i, ShapeIndex shape) {
    const Key cell = cells_.CellOf(i);
    for (int which = 0; which < Key::kChildren; ++which) {
      if (Meets(shape, cell.Child(which))) AddIn(cells_.ChildOf(i, which), shape);
    }
  }

  void RemoveIn(CellIndex i, ShapeIndex shape) {
    CommonPoints common;
    if (cells_[i].is_open) {
      const Key cell = cells_.CellOf(i);
      for (int which = 0; which < Key::kChildren; ++which) {
        const CellIndex child = cells_.ChildOf(i, which);
        if (Meets(shape, cell.Child(which))) RemoveIn(child, shape);
        if (!common.are_apart()) common.Add(CommonOf(child), shapes_);
      }
      if (!common.has_features()) emptied_.push_back(i);
    } else if (cells_[i].list != kNone) {
      std::vector<ShapeIndex>& features = lists_[cells_[i].list];
      *std::find(features.begin(), features.end(), shape) = features.back();
      features.pop_back();
      // With fewer features they have more in common, never less.
      const CommonPoints before = CommonOf(i);
      for (const ShapeIndex left : features) {
        common.Add(left, shapes_);
        if (common == before) break;
      }
      if (features.size() == 1) lists_.Take(&cells_[i].list);
    }
    SetCommon(i, common);
  }

  // Do the features of `own` have nothing in common with those of the cell beside i?
  bool IsApartFrom(const CommonPoints& own, CellIndex i,
                   const typename CellTree<D>::Offset& offset) const {
    bool is_exact;
    CellIndex j = cells_.Beside(i, offset, &is_exact);
    if (j == kNone || j == i) return false;
    for (; j != kRoot && !cells_[cells_.ParentOf(j)].is_open; is_exact = false) {
      j = cells_.ParentOf(j);
    }
    const PackedPoints& packed = cells_[j].common;
    if (!packed.has_features()) return false;
    if (is_exact) {
      if (packed.b == PackedPoints::kApart) return true;
      return own.AreApartFrom(CommonOf(j), shapes_);
    }
    const Key around = cells_.CellOf(j);
    Key cell = cells_.CellOf(i);
    for (int k = 0; k < D; ++k) cell.at[k] += static_cast<std::uint64_t>(offset[k]);
    CommonPoints both = own;
    for (const ShapeIndex shape : FeaturesOf(j)) {
      if (MeetsDownTo(shape, around, cell)) both.Add(shape, shapes_);
      if (both.are_apart()) return true;
    }
    return false;
  }
  // As if all cells from `around` down to `cell` were open.
  bool MeetsDownTo(ShapeIndex shape, const Key& around, Key cell) const {
    for (; cell.level > around.level; cell = cell.Parent()) {
      if (!Meets(shape, cell)) return false;
    }
    return true;
  }

  template <class F>
  void ForEachNearIn(CellIndex i, const Key& cell, ShapeIndex shape, F& f) const {
    if (i != kRoot && !shapes_[shape].Meets(grid_.BlockOf(cell))) return;
    f(i);
    if (!cells_[i].is_open) return;
    for (int which = 0; which < Key::kChildren; ++which) {
      const CellIndex child = cells_.ChildOf(i, which);
      if (!cells_[child].common.has_features()) continue;
      ForEachNearIn(child, cell.Child(which), shape, f);
    }
  }

  const Grid<D>& grid_;
  CellTree<D>& cells_;
  const Shapes& shapes_;
  ListPool lists_;  // of leaves with two features or more
  ListPool many_;   // points in common, where there are more than two
  std::vector<CellIndex> emptied_;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_
