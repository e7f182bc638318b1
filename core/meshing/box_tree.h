// Regions of any size: which ones may meet a ball? A quadtree or octree. A region is kept in the
// smallest cell of about its own size that has its centre, and may extend beyond the cell by half
// of the cell's side. A cell also knows the box around its regions and those of its subtree, which
// is much smaller than the cell where regions lie on a surface. Each region has a key; a search may
// skip those of large key.
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
#include "core/meshing/extent.h"

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
      largest_ = std::max({largest_, std::fabs(lo[k]), std::fabs(hi[k])});
      root_.centre[k] = 0.5 * (lo[k] + hi[k]);
      root_.half = std::max(root_.half, hi[k] - lo[k]);
    }
    nodes_.emplace_back();
  }

  // O(depth), at most 40, plus the regions in the same cell.
  Index Add(Region region);
  void Remove(Index index);
  bool empty() const { return count_ == 0; }
  std::size_t size() const { return count_; }
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
  // enter(least key, box) is false.
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
    std::uint32_t first = kNone;           // the first item, or kNone
    double least = INFINITY;               // the least key in the subtree
    Extent<D> box = Extent<D>::Nothing();  // around the regions in the subtree
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
  void Cover(Node& node, const Region& region) const;
  static void Cover(Node& node, const Node& child);
  void Shrink(std::uint32_t node);

  Cell root_;
  double largest_ = 0;  // the largest coordinate of the box covered
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
  Cover(nodes_[cell.node], items_[index].region);
  for (std::uint32_t n = cell.node; nodes_[n].parent != kNone; n = nodes_[n].parent) {
    Cover(nodes_[nodes_[n].parent], nodes_[n]);
  }
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
  Shrink(node);
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

// The box is wider than the region by more than tests of regions round.
template <int D, class Region>
void BoxTree<D, Region>::Cover(Node& node, const Region& region) const {
  double largest = std::max(largest_, region.radius);
  for (int k = 0; k < D; ++k) {
    largest = std::max({largest, std::fabs(region.lo[k]), std::fabs(region.hi[k])});
  }
  const double margin = region.radius * kBarelyWider + 0x1p-44 * largest;
  node.box.AddBall(region.lo, margin);
  node.box.AddBall(region.hi, margin);
  node.least = std::min(node.least, region.Key());
}

template <int D, class Region>
void BoxTree<D, Region>::Cover(Node& node, const Node& child) {
  node.box.AddBall({child.box.lo}, 0);
  node.box.AddBall({child.box.hi}, 0);
  node.least = std::min(node.least, child.least);
}

// Updates `least` and `box` from a node that has lost an item up to the root. Frees empty cells.
template <int D, class Region>
void BoxTree<D, Region>::Shrink(std::uint32_t n) {
  while (n != kNone) {
    Node& node = nodes_[n];
    node.least = INFINITY;
    node.box = Extent<D>::Nothing();
    for (std::uint32_t i = node.first; i != kNone; i = items_[i].next)
      Cover(node, items_[i].region);
    for (const std::uint32_t child : node.child) {
      if (child != kNone) Cover(node, nodes_[child]);
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
  Extent<D> around = Extent<D>::Nothing();
  around.AddBall(centre, radius);
  return Visit(
      [&](double least, const Extent<D>& box) {
        if (!(least < bound)) return false;
        bool beyond = false;
        for (int k = 0; k < D; ++k) {
          beyond |= !(box.lo[k] <= around.hi[k]);
          beyond |= !(around.lo[k] <= box.hi[k]);
        }
        if (beyond) return false;
        Point middle;
        std::array<double, D> half;
        for (int k = 0; k < D; ++k) {
          middle[k] = 0.5 * (box.lo[k] + box.hi[k]);
          half[k] = 0.5 * (box.hi[k] - box.lo[k]);
        }
        return !is_hidden(middle, half);
      },
      [&](Index i) { return items_[i].region.Key() < bound && accept(i); });
}

template <int D, class Region>
template <class Enter, class Accept>
bool BoxTree<D, Region>::Visit(Enter enter, Accept accept) const {
  std::array<std::uint32_t, (1 << D) * kMostDepth> stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!enter(node.least, node.box)) continue;
    for (std::uint32_t i = node.first; i != kNone; i = items_[i].next) {
      if (accept(i)) return true;
    }
    for (const std::uint32_t child : node.child) {
      if (child != kNone) stack[top++] = child;
    }
  }
  return false;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_BOX_TREE_H_
