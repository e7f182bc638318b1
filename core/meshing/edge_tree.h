// A hierarchy of boxes over edges. Immutable, thread-safe. O(n log n) to build for n edges.
#ifndef DYNMESH_CORE_MESHING_EDGE_TREE_H_
#define DYNMESH_CORE_MESHING_EDGE_TREE_H_

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::meshing {

template <int D>
class EdgeTree {
 public:
  using Point = geometry::Point<D>;
  struct Edge {
    Point a, b;
  };

  // REQUIRES: there is an edge.
  explicit EdgeTree(std::vector<Edge> edges) : edges_(std::move(edges)) {
    Build(0, static_cast<std::uint32_t>(edges_.size()));
  }

  // The corners of the least box around all edges.
  const Point& lo() const { return nodes_.front().lo; }
  const Point& hi() const { return nodes_.front().hi; }

  // Calls at_leaf(edges) for a few edges at a time until it returns true, and returns whether it
  // did. Skips boxes for which enter(lo, hi) is false; that of a leaf is asked right before it.
  template <class Enter, class AtLeaf>
  bool Visit(Enter enter, AtLeaf at_leaf) const {
    std::uint32_t stack[64] = {0};
    int top = 1;
    while (top > 0) {
      const std::uint32_t at = stack[--top];
      const Node& node = nodes_[at];
      if (!enter(node.lo, node.hi)) continue;
      if (node.second_child != 0) {
        stack[top++] = node.second_child;
        stack[top++] = at + 1;
      } else if (at_leaf(
                     std::span<const Edge>(edges_).subspan(node.first, node.last - node.first))) {
        return true;
      }
    }
    return false;
  }

 private:
  // A box over edges [first, last). An inner node's first child is the next node.
  struct Node {
    Point lo, hi;
    std::uint32_t first, last;
    std::uint32_t second_child;  // 0: a leaf
  };

  std::uint32_t Build(std::uint32_t first, std::uint32_t last);

  std::vector<Edge> edges_;
  std::vector<Node> nodes_;
};

template <int D>
std::uint32_t EdgeTree<D>::Build(std::uint32_t first, std::uint32_t last) {
  constexpr std::uint32_t kLeaf = 4;
  Node node{edges_[first].a, edges_[first].a, first, last, 0};
  for (std::uint32_t i = first; i < last; ++i) {
    for (const Point& p : {edges_[i].a, edges_[i].b}) {
      for (int axis = 0; axis < D; ++axis) {
        node.lo[axis] = std::min(node.lo[axis], p[axis]);
        node.hi[axis] = std::max(node.hi[axis], p[axis]);
      }
    }
  }
  const auto at = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back(node);
  if (last - first <= kLeaf) return at;
  int widest = D - 1;
  for (int axis = D - 2; axis >= 0; --axis) {
    if (node.hi[axis] - node.lo[axis] > node.hi[widest] - node.lo[widest]) widest = axis;
  }
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(edges_.begin() + first, edges_.begin() + middle, edges_.begin() + last,
                   [widest](const Edge& s, const Edge& t) {
                     return s.a[widest] + s.b[widest] < t.a[widest] + t.b[widest];
                   });
  Build(first, middle);
  const std::uint32_t second = Build(middle, last);
  nodes_[at].second_child = second;
  return at;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_EDGE_TREE_H_
