// Regions of any size: which ones may meet a ball? A loose quadtree or octree. A region is kept in
// the smallest cell of about its own size, and may extend beyond the cell by half of the cell's
// side. Each region has a key; a search may skip those of large key.
//
// A Region has corners `lo` and `hi` and a `radius`: it lies within that distance of the box
// between them. LeastCell() >= 0 is the size of the smallest cell that is useful for it; Key() is
// any number.
//
// Answers are a function of the regions present. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_BOX_TREE_H_
#define DYNMESH_CORE_MESHING_BOX_TREE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/point.h"

namespace dynmesh::meshing {

// For searches that skip nothing.
inline constexpr auto kNothingHidden = [](const auto& /*centre*/, const auto& /*half*/) {
  return false;
};

template <int D, class Region>
class BoxTree {
 public:
  using Point = geometry::Point<D>;
  using Index = std::uint32_t;

  // Covers the box: regions should meet it.
  BoxTree(const Point& lo, const Point& hi) : root_{0, {}, 0} {
    for (int k = 0; k < D; ++k) {
      root_.centre[k] = 0.5 * (lo[k] + hi[k]);
      root_.half = std::max(root_.half, hi[k] - lo[k]);
    }
    nodes_.emplace_back();
  }

  // O(depth), at most 40, plus the regions in the same cell.
  Index Add(Region region);
  void Remove(Index index);
  bool empty() const { return count_ == 0; }
  const Region& operator[](Index index) const { return items_[index].region; }

  // True if accept(index) holds for a region of key below `bound` near the ball. Calls accept for
  // all that meet the ball, until one is accepted, and for some others. If none is: O(cells of its
  // size nearby).
  template <class Accept>
  bool Any(const Point& centre, double radius, double bound, Accept accept) const {
    return Any(centre, radius, bound, kNothingHidden, accept);
  }
  // The same, but may skip regions in boxes for which is_hidden(centre, half of the sides) is true.
  template <class IsHidden, class Accept>
  bool Any(const Point& centre, double radius, double bound, IsHidden is_hidden,
           Accept accept) const;
  // Calls accept(index) until it returns true, and returns whether it did. Skips boxes for which
  // enter(least key, centre, half of the sides) is false. The largest regions are in no box: for
  // them the half is INFINITY.
  template <class Enter, class Accept>
  bool Visit(Enter enter, Accept accept) const;

  std::size_t bytes() const {
    return nodes_.capacity() * sizeof(Node) + items_.capacity() * sizeof(Item);
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr int kMostDepth = 40;
  static constexpr std::array<std::uint32_t, 1 << D> Filled() {
    std::array<std::uint32_t, 1 << D> none{};
    none.fill(kNone);
    return none;
  }
  struct Node {
    std::array<std::uint32_t, 1 << D> child = Filled();
    std::uint32_t parent = kNone;
    std::uint32_t first = kNone;  // the first item, or kNone
    double least = INFINITY;      // the least key in the subtree
  };
  struct Item {
    Region region;
    std::uint32_t node = kNone, next = kNone;
  };
  struct Cell {
    std::uint32_t node;
    Point centre;
    double half;
  };

  static int Quadrant(const Point& p, const Cell& cell) {
    int q = 0;
    for (int k = 0; k < D; ++k) q |= (p[k] >= cell.centre[k] ? 1 : 0) << k;
    return q;
  }
  static Cell Child(const Cell& cell, int quadrant, std::uint32_t node) {
    Cell child{node, cell.centre, cell.half / 2};
    for (int k = 0; k < D; ++k) {
      child.centre[k] += (quadrant >> k & 1) != 0 ? child.half : -child.half;
    }
    return child;
  }
  std::uint32_t NewNode(std::uint32_t parent);
  void UpdateLeast(std::uint32_t node);

  Cell root_;
  std::vector<Node> nodes_;
  std::vector<Item> items_;
  std::vector<std::uint32_t> free_nodes_, free_items_;
  std::size_t count_ = 0;
};

template <int D, class Region>
typename BoxTree<D, Region>::Index BoxTree<D, Region>::Add(Region region) {
  Point centre;
  double widest = 0;
  for (int k = 0; k < D; ++k) {
    centre[k] = 0.5 * (region.lo[k] + region.hi[k]);
    widest = std::max(widest, region.hi[k] - region.lo[k]);
  }
  const double extent = 0.5 * widest + region.radius;
  const double size = std::max(extent, region.LeastCell());
  Cell cell = root_;
  for (int depth = 0; depth < kMostDepth && cell.half / 2 >= size; ++depth) {
    const int quadrant = Quadrant(centre, cell);
    std::uint32_t child = nodes_[cell.node].child[quadrant];
    if (child == kNone) {
      child = NewNode(cell.node);
      nodes_[cell.node].child[quadrant] = child;
    }
    cell = Child(cell, quadrant, child);
  }
  Index index;
  if (free_items_.empty()) {
    index = static_cast<Index>(items_.size());
    items_.emplace_back();
  } else {
    index = free_items_.back();
    free_items_.pop_back();
  }
  items_[index] = {std::move(region), cell.node, nodes_[cell.node].first};
  nodes_[cell.node].first = index;
  ++count_;
  UpdateLeast(cell.node);
  return index;
}

template <int D, class Region>
void BoxTree<D, Region>::Remove(Index index) {
  const std::uint32_t node = items_[index].node;
  std::uint32_t* link = &nodes_[node].first;
  while (*link != index) link = &items_[*link].next;
  *link = items_[index].next;
  items_[index].region = {};
  free_items_.push_back(index);
  --count_;
  UpdateLeast(node);
}

template <int D, class Region>
std::uint32_t BoxTree<D, Region>::NewNode(std::uint32_t parent) {
  std::uint32_t n;
  if (free_nodes_.empty()) {
    n = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
  } else {
    n = free_nodes_.back();
    free_nodes_.pop_back();
    nodes_[n] = {};
  }
  nodes_[n].parent = parent;
  return n;
}

// Updates `least` from a node with changed items up to the root. Frees empty cells.
template <int D, class Region>
void BoxTree<D, Region>::UpdateLeast(std::uint32_t n) {
  while (n != kNone) {
    Node& node = nodes_[n];
    node.least = INFINITY;
    for (std::uint32_t i = node.first; i != kNone; i = items_[i].next) {
      node.least = std::min(node.least, items_[i].region.Key());
    }
    for (const std::uint32_t child : node.child) {
      if (child != kNone) node.least = std::min(node.least, nodes_[child].least);
    }
    const std::uint32_t parent = node.parent;
    if (node.least == INFINITY && parent != kNone) {
      *std::find(nodes_[parent].child.begin(), nodes_[parent].child.end(), n) = kNone;
      free_nodes_.push_back(n);
    }
    n = parent;
  }
}

template <int D, class Region>
template <class IsHidden, class Accept>
bool BoxTree<D, Region>::Any(const Point& centre, double radius, double bound, IsHidden is_hidden,
                             Accept accept) const {
  return Visit(
      [&](double least, const Point& middle, double half) {
        if (!(least < bound)) return false;
        if (half == INFINITY) return true;
        bool beyond = false;
        for (int k = 0; k < D; ++k) beyond |= std::fabs(centre[k] - middle[k]) > half + radius;
        if (beyond) return false;
        std::array<double, D> halves;
        halves.fill(half);
        return !is_hidden(middle, halves);
      },
      [&](Index i) { return items_[i].region.Key() < bound && accept(i); });
}

template <int D, class Region>
template <class Enter, class Accept>
bool BoxTree<D, Region>::Visit(Enter enter, Accept accept) const {
  std::array<Cell, (1 << D) * kMostDepth> stack;
  std::size_t top = 0;
  stack[top++] = root_;
  while (top > 0) {
    const Cell cell = stack[--top];
    const Node& node = nodes_[cell.node];
    // A region extends at most by the side's length from the centre of its cell. The root is an
    // exception: it holds all larger regions.
    const double half = cell.node == 0 ? INFINITY : 2 * cell.half * kBarelyWider;
    if (!enter(node.least, cell.centre, half)) continue;
    for (std::uint32_t i = node.first; i != kNone; i = items_[i].next) {
      if (accept(i)) return true;
    }
    for (int q = 0; q < 1 << D; ++q) {
      if (node.child[q] != kNone) stack[top++] = Child(cell, q, node.child[q]);
    }
  }
  return false;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_BOX_TREE_H_
