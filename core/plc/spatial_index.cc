#include "core/plc/spatial_index.h"

#include <algorithm>
#include <array>
#include <utility>

namespace dynmesh::plc {
namespace {

// Covers the error of positions in units, and closed cells.
constexpr double kCellReach = 0.25;
// 3D: segments and facets count towards splitting until cells are so much smaller.
constexpr double kMostCellsLong = 16;
constexpr double kMostCellsWide = 4;

void InsertInOrder(std::vector<Slot>& slots, Slot slot) {
  if (slots.empty() || slots.back() < slot) {  // mostly: slots are given out in order
    slots.push_back(slot);
    return;
  }
  slots.insert(std::lower_bound(slots.begin(), slots.end(), slot), slot);
}

void EraseInOrder(std::vector<Slot>& slots, Slot slot) {
  const auto it = std::lower_bound(slots.begin(), slots.end(), slot);
  if (it != slots.end() && *it == slot) slots.erase(it);
}

void EraseValue(std::vector<Slot>& slots, Slot slot) {
  const auto it = std::find(slots.begin(), slots.end(), slot);
  if (it == slots.end()) return;
  *it = slots.back();
  slots.pop_back();
}

template <typename T>
Slot Put(LargeVector<T>& table, std::vector<Slot>& free_slots, const T& value) {
  if (free_slots.empty()) {
    table.push_back(value);
    return static_cast<Slot>(table.size() - 1);
  }
  const Slot slot = free_slots.back();
  free_slots.pop_back();
  table[slot] = value;
  return slot;
}

}  // namespace

template <int D>
SpatialIndex<D>::SpatialIndex(const CellGrid<D>& grid) : grid_(grid), nodes_(kChildren) {}

template <int D>
int SpatialIndex<D>::ChildAt(const Cell& cell, const UnitPoint<D>& at) {
  const std::int64_t half = cell.side / 2;
  int child = 0;
  for (int i = 0; i < D; ++i) {
    if (CellGrid<D>::Quantise(at[i]) >= cell.at[i] + half) child |= 1 << i;
  }
  return child;
}

template <int D>
Slot SpatialIndex<D>::Insert(const PointFeature<D>& point) {
  const Slot slot = Put(points_, free_points_, point);
  InsertPointAt(0, grid_.root(), slot, grid_.ToUnits(point.p));
  return slot;
}

template <int D>
Slot SpatialIndex<D>::Insert(const SegmentFeature<D>& segment) {
  const Slot slot = Put(segments_, free_segments_, GridSegment<D>(segment, grid_));
  InsertThingAt<GridSegment<D>>(0, grid_.root(), slot);
  return slot;
}

template <int D>
Slot SpatialIndex<D>::Insert(const Facet& facet) requires(D == 3) {
  Slot slot = {};
  if constexpr (D == 3) {  // clang 14 instantiates it for 2D, too
    slot = Put(facets_, free_facets_, GridFacet(facet, grid_));
    InsertThingAt<GridFacet>(0, grid_.root(), slot);
  }
  return slot;
}

template <int D>
void SpatialIndex<D>::EraseFacet(Slot slot) requires(D == 3) {
  if constexpr (D == 3) {
    EraseThingAt<GridFacet>(0, grid_.root(), slot);
    facets_[slot] = {};
    free_facets_.push_back(slot);
  }
}

template <int D>
template <typename Thing>
const LargeVector<Thing>& SpatialIndex<D>::TableOf() const {
  if constexpr (std::is_same_v<Thing, GridFacet>) {
    return facets_;
  } else {
    return segments_;
  }
}

template <int D>
template <typename Thing>
std::vector<Slot>& SpatialIndex<D>::ListOf(Node& node) {
  if constexpr (std::is_same_v<Thing, GridFacet>) {
    return node.facets;
  } else {
    return node.loose;
  }
}

template <int D>
void SpatialIndex<D>::ErasePoint(Slot slot) {
  ErasePointAt(0, grid_.root(), slot, grid_.ToUnits(points_[slot].p));
  free_points_.push_back(slot);
}

template <int D>
void SpatialIndex<D>::EraseSegment(Slot slot) {
  EraseThingAt<GridSegment<D>>(0, grid_.root(), slot);
  free_segments_.push_back(slot);
}

template <int D>
void SpatialIndex<D>::InsertPointAt(NodeIndex n, const Cell& cell, Slot slot,
                                    const UnitPoint<D>& at) {
  if (nodes_[n].children == 0) {
    nodes_[n].points.push_back(slot);
    SplitIfCrowded(n, cell);
    return;
  }
  const int child = ChildAt(cell, at);
  InsertPointAt(nodes_[n].children + child, cell.Child(child), slot, at);
}

// The decisions (meets, spans, leaf) are functions of segment, cell and tree, and EraseThingAt
// repeats them.
template <int D>
template <typename Thing>
void SpatialIndex<D>::InsertThingAt(NodeIndex n, const Cell& cell, Slot slot) {
  const Thing& thing = TableOf<Thing>()[slot];
  if (!thing.Meets(cell, kCellReach)) return;
  if constexpr (D == 2) {
    if (thing.Spans(cell)) {
      std::unique_ptr<ChordList>& chords = nodes_[n].chords;
      if (chords == nullptr) chords = std::make_unique<ChordList>(&segments_);
      chords->Insert(slot);
      return;
    }
  }
  if (nodes_[n].children == 0) {
    InsertInOrder(ListOf<Thing>(nodes_[n]), slot);
    // Thousands of large ones may be in a leaf: they are not counted again for each that comes.
    if (Crowds(thing, cell)) SplitIfCrowded(n, cell);
  } else {
    thing.ForChildrenNear(cell, kCellReach, [&](int i) {
      InsertThingAt<Thing>(nodes_[n].children + i, cell.Child(i), slot);
    });
  }
}

template <int D>
void SpatialIndex<D>::ErasePointAt(NodeIndex n, const Cell& cell, Slot slot,
                                   const UnitPoint<D>& at) {
  if (nodes_[n].children == 0) {
    EraseValue(nodes_[n].points, slot);
    return;
  }
  const int child = ChildAt(cell, at);
  ErasePointAt(nodes_[n].children + child, cell.Child(child), slot, at);
  MergeIfSparse(n, cell);
}

template <int D>
template <typename Thing>
void SpatialIndex<D>::EraseThingAt(NodeIndex n, const Cell& cell, Slot slot) {
  const Thing& thing = TableOf<Thing>()[slot];
  if (!thing.Meets(cell, kCellReach)) return;
  if constexpr (D == 2) {
    if (thing.Spans(cell)) {
      std::unique_ptr<ChordList>& chords = nodes_[n].chords;
      if (chords == nullptr) return;
      chords->Erase(slot);
      if (chords->size() == 0) chords.reset();
      return;
    }
  }
  if (nodes_[n].children == 0) {
    EraseInOrder(ListOf<Thing>(nodes_[n]), slot);
  } else {
    thing.ForChildrenNear(cell, kCellReach, [&](int i) {
      EraseThingAt<Thing>(nodes_[n].children + i, cell.Child(i), slot);
    });
    MergeIfSparse(n, cell);
  }
}

template <int D>
typename SpatialIndex<D>::NodeIndex SpatialIndex<D>::AllocateChildren() {
  if (free_blocks_.empty()) {
    nodes_.resize(nodes_.size() + kChildren);
    return static_cast<NodeIndex>(nodes_.size() - kChildren);
  }
  const NodeIndex block = free_blocks_.back();
  free_blocks_.pop_back();
  return block;
}

template <int D>
template <typename Thing>
bool SpatialIndex<D>::Crowds(const Thing& thing, const Cell& cell) {
  constexpr double kMostCells = std::is_same_v<Thing, GridFacet> ? kMostCellsWide : kMostCellsLong;
  return D == 2 || thing.Extent() <= kMostCells * static_cast<double>(cell.side);
}

// How many features of a leaf count towards splitting it.
template <int D>
std::size_t SpatialIndex<D>::CrowdIn(const Node& node, const Cell& cell) {
  const std::size_t all = node.points.size() + node.loose.size();
  if constexpr (D == 2) {
    return all;
  } else {
    if (all + node.facets.size() == 0) return 0;
    looked_at_ += node.loose.size() + node.facets.size();
    const auto count = [&](const std::vector<Slot>& slots, const auto& table) {
      return static_cast<std::size_t>(std::count_if(
          slots.begin(), slots.end(), [&](Slot s) { return Crowds(table[s], cell); }));
    };
    return node.points.size() + count(node.loose, segments_) + count(node.facets, facets_);
  }
}

template <int D>
void SpatialIndex<D>::SplitIfCrowded(NodeIndex n, const Cell& cell) {
  if (cell.side == 1 || CrowdIn(nodes_[n], cell) <= kCapacity) return;
  const NodeIndex children = AllocateChildren();
  nodes_[n].children = children;
  const std::vector<Slot> points = std::exchange(nodes_[n].points, {});
  const std::vector<Slot> loose = std::exchange(nodes_[n].loose, {});
  std::vector<Slot> facets;
  if constexpr (D == 3) facets = std::exchange(nodes_[n].facets, {});
  for (const Slot slot : points) {
    nodes_[children + ChildAt(cell, grid_.ToUnits(points_[slot].p))].points.push_back(slot);
  }
  for (int i = 0; i < kChildren; ++i) {
    for (const Slot slot : loose) {
      InsertThingAt<GridSegment<D>>(children + i, cell.Child(i), slot);
    }
    if constexpr (D == 3) {
      for (const Slot slot : facets) InsertThingAt<GridFacet>(children + i, cell.Child(i), slot);
    }
    SplitIfCrowded(children + i, cell.Child(i));
  }
}

// A segment that is in children, as a chord or loose, is loose in the parent: it does not span the
// parent, or it would be a chord there.
template <int D>
void SpatialIndex<D>::MergeIfSparse(NodeIndex n, const Cell& cell) {
  const NodeIndex children = nodes_[n].children;
  std::size_t held = 0;
  for (NodeIndex c = children; c < children + kChildren; ++c) {
    const Node& child = nodes_[c];
    if (child.children != 0) return;
    held += CrowdIn(child, cell);
    if constexpr (D == 2) held += child.chords != nullptr ? child.chords->size() : 0;
  }
  if (held > kMergeBelow) return;
  Node& node = nodes_[n];
  const auto append = [](std::vector<Slot>& all, const std::vector<Slot>& some) {
    all.insert(all.end(), some.begin(), some.end());
  };
  const auto make_unique = [](std::vector<Slot>& slots) {
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  };
  for (NodeIndex c = children; c < children + kChildren; ++c) {
    Node& child = nodes_[c];
    append(node.points, child.points);
    append(node.loose, child.loose);
    if constexpr (D == 2) {
      if (child.chords != nullptr) child.chords->AppendTo(node.loose);
    } else {
      append(node.facets, child.facets);
    }
    child = Node();
  }
  make_unique(node.loose);
  if constexpr (D == 3) make_unique(node.facets);
  node.children = 0;
  free_blocks_.push_back(children);
}

template class SpatialIndex<2>;
template class SpatialIndex<3>;

}  // namespace dynmesh::plc
