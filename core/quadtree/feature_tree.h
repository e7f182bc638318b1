// Which features meet which cells. A cell of this tree is *open*, with children in it, or a leaf
// with a list of the features that meet it; of an open cell only what these have in common is kept.
//
// All answers are functions of the features and the grid: which cells are open does not affect
// them. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_
#define DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/quadtree/cell.h"
#include "core/quadtree/cell_tree.h"
#include "core/quadtree/common_points.h"
#include "core/quadtree/list_pool.h"
#include "core/quadtree/offsets.h"
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
  bool IsCrowded(CellIndex i) {
    const PackedPoints& own = cells_[i].common;
    if (!own.has_features() || cells_.LevelOf(i) >= grid_.most_level()) return false;
    if (own.are_apart()) return true;
    if (i == kRoot) return false;
    const auto& around_parent = cells_.BlockAround(cells_.ParentOf(i));
    for (std::size_t offset = 0; offset < around_parent.size(); ++offset) {
      const auto beside = cells_.BesideChild(around_parent, CellTree<D>::WhichOf(i), offset);
      if (beside.cell == kNone || beside.cell == i) continue;
      if (AreApart(i, beside, offset)) return true;
    }
    return false;
  }

  // Gives a leaf's list to its children.
  void Open(CellIndex i) {
    cells_.MakeChildren(i);
    const PackedPoints common = cells_[i].common;
    const ListPool::List list = lists_.Take(&cells_[i].list);
    const std::span<const ShapeIndex> features =
        common.is_lone() ? std::span(&common.a, 1) : std::span(list);
    cells_[i].is_open = true;
    // First how many features meet each child: then no list grows.
    const Halves<D> halves = grid_.HalvesOf(cells_.CellOf(i));
    std::array<std::uint32_t, Cell<D>::kChildren> counts = {};
    met_.clear();
    for (const ShapeIndex shape : features) {
      met_.push_back(shapes_[shape].ChildrenMet(halves));
      ForEachBit(met_.back(), [&](int which) {
        ++counts[static_cast<std::size_t>(which)];
        AddToCommon(cells_.ChildOf(i, which), shape);
      });
    }
    std::array<ListPool::List, Cell<D>::kChildren> of_children;
    for (std::size_t which = 0; which < counts.size(); ++which) {
      if (counts[which] > 1) of_children[which].reserve(counts[which]);
    }
    for (std::size_t k = 0; k < features.size(); ++k) {
      ForEachBit(met_[k], [&](int which) {
        const auto child = static_cast<std::size_t>(which);
        if (counts[child] > 1) of_children[child].push_back(features[k]);
      });
    }
    for (std::size_t which = 0; which < counts.size(); ++which) {
      if (counts[which] < 2) continue;
      cells_[cells_.ChildOf(i, static_cast<int>(which))].list =
          lists_.Add(std::move(of_children[which]));
    }
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

  // Calls f(i, may_meet) for the cells i that a feature meets, with an open parent, whose block
  // this feature meets, and maybe for some with a block that it passes by. may_meet(): MayMeet of
  // cell i.
  template <class F>
  void ForEachNear(ShapeIndex shape, F f) const {
    ForEachNearIn(kRoot, Cell<D>(), shapes_[shape], f);
  }

  std::size_t bytes() const { return lists_.bytes() + many_.bytes(); }

 private:
  using Key = Cell<D>;

  template <class F>
  static void ForEachBit(std::uint32_t bits, F f) {
    for (; bits != 0; bits &= bits - 1) f(std::countr_zero(bits));
  }
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

  void AddToCommon(CellIndex i, ShapeIndex shape) {
    PackedPoints& packed = cells_[i].common;
    if (!packed.has_features()) {
      packed = {shape, PackedPoints::kLone};
    } else if (!packed.are_apart()) {
      CommonPoints common = CommonOf(i);
      common.Add(shape, shapes_);
      SetCommon(i, common);
    }
  }
  void AddIn(CellIndex i, ShapeIndex shape) {
    const PackedPoints before = cells_[i].common;
    AddToCommon(i, shape);
    if (cells_[i].is_open) {
      const std::uint32_t met = shapes_[shape].ChildrenMet(grid_.HalvesOf(cells_.CellOf(i)));
      return ForEachBit(met, [&](int which) { AddIn(cells_.ChildOf(i, which), shape); });
    }
    std::uint32_t& list = cells_[i].list;
    if (list != kNone) {
      lists_[list].push_back(shape);
    } else if (before.is_lone()) {
      list = lists_.Add({before.a, shape});
    }
  }

  void RemoveIn(CellIndex i, ShapeIndex shape) {
    CommonPoints common;
    if (cells_[i].is_open) {
      const std::uint32_t met = shapes_[shape].ChildrenMet(grid_.HalvesOf(cells_.CellOf(i)));
      ForEachBit(met, [&](int which) { RemoveIn(cells_.ChildOf(i, which), shape); });
      for (int which = 0; which < Key::kChildren && !common.are_apart(); ++which) {
        common.Add(CommonOf(cells_.ChildOf(i, which)), shapes_);
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

  // What CommonPoints keeps, or the points of a lone feature. REQUIRES: there are features.
  std::span<const PointIndex> PointsOf(const PackedPoints& packed) const {
    if (packed.is_lone()) return shapes_[packed.a].points();
    if (packed.are_apart()) return {};
    if (packed.b == PackedPoints::kMany) return many_[packed.a];
    return {&packed.a, packed.b == kNone ? 1u : 2u};
  }
  // Do the features of cell i have nothing in common with those of the cell beside it?
  bool AreApart(CellIndex i, typename CellTree<D>::Found beside, std::size_t offset) const {
    CellIndex j = beside.cell;
    for (; j != kRoot && !cells_[cells_.ParentOf(j)].is_open; beside.is_exact = false) {
      j = cells_.ParentOf(j);
    }
    const PackedPoints& packed = cells_[j].common;
    if (!packed.has_features()) return false;
    if (beside.is_exact) return AreDisjoint(PointsOf(cells_[i].common), PointsOf(packed));
    const Key around = cells_.CellOf(j);
    Key cell = cells_.CellOf(i);
    for (int k = 0; k < D; ++k) {
      cell.at[k] += static_cast<std::uint64_t>(Offsets<D>::Along(offset, k));
    }
    CommonPoints both = CommonOf(i);
    for (const ShapeIndex shape : FeaturesOf(j)) {
      if (MeetsDownTo(shape, around, cell)) both.Add(shape, shapes_);
      if (both.are_apart()) return true;
    }
    return false;
  }
  // Both are sorted.
  static bool AreDisjoint(std::span<const PointIndex> a, std::span<const PointIndex> b) {
    for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
      if (a[i] == b[j]) return false;
      ++(a[i] < b[j] ? i : j);
    }
    return true;
  }
  // As if all cells from `around` down to `cell` were open.
  bool MeetsDownTo(ShapeIndex shape, const Key& around, Key cell) const {
    for (; cell.level > around.level; cell = cell.Parent()) {
      if (!Meets(shape, cell)) return false;
    }
    return true;
  }

  template <class F>
  void ForEachNearIn(CellIndex i, const Key& cell, const Shape<D>& shape, F& f) const {
    if (i != kRoot && !shape.MayMeet(grid_.BlockOf(cell))) return;
    f(i, [&] { return shape.MayMeet(grid_.BoxOf(cell)); });
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
  std::vector<std::uint32_t> met_;  // Open's memory
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_FEATURE_TREE_H_
