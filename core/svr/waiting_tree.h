// Is one of the uninserted points of SVR in a ball? A quadtree, octree, ... of them, asked before
// the point location: most queries of Steiner points find none, and a walk over Voronoi cells is
// long. Thread-compatible.
#ifndef DYNMESH_CORE_SVR_WAITING_TREE_H_
#define DYNMESH_CORE_SVR_WAITING_TREE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "core/svr/kernel.h"

namespace dynmesh::svr {

template <int D>
class WaitingTree {
 public:
  using Point = geometry::Point<D>;

  // `points`: positions by index; must outlive this. `lo`, `hi`: the cube that they are in.
  WaitingTree(const Positions<D>& points, const Point& lo, const Point& hi)
      : points_(points), half_((hi[0] - lo[0]) / 2), nodes_(1) {
    for (int k = 0; k < D; ++k) middle_[k] = lo[k] + half_;
  }

  // O(depth). Remove: of a point that was added.
  void Add(VertexIndex p);
  void Remove(VertexIndex p);
  // Conservative: may return true needlessly, if a point is near the ball's surface, never false
  // wrongly. O(depth), and O(1) cells of an eighth of the ball's size.
  bool MayHavePoint(const Ball<D>& ball, double radius);

 private:
  static constexpr std::size_t kChildren = std::size_t{1} << D;
  static constexpr int kMostDepth = 44;
  struct Node {
    std::uint32_t children = kNone;  // the first of kChildren
    std::uint32_t count = 0;         // points below
    VertexIndex all = 0;             // exclusive or of them: if there is one, it is this
  };
  struct Cell {
    std::uint32_t node;
    Point middle;
    double half;
  };

  static std::size_t ChildAt(const Cell& cell, const Point& p) {
    std::size_t which = 0;
    for (int k = 0; k < D; ++k) which |= (p[k] >= cell.middle[k] ? std::size_t{1} : 0) << k;
    return which;
  }
  Cell Child(const Cell& cell, std::size_t which) const {
    Cell child = {nodes_[cell.node].children + static_cast<std::uint32_t>(which), cell.middle,
                  cell.half / 2};
    for (int k = 0; k < D; ++k) child.middle[k] += (which >> k & 1) != 0 ? child.half : -child.half;
    return child;
  }
  void Change(Node& node, VertexIndex p, std::uint32_t by) {
    node.count += by;
    node.all ^= p;
  }

  const Positions<D>& points_;
  Point middle_;
  double half_;
  LargeVector<Node> nodes_;
  std::vector<Cell> stack_;
};

// --- Implementation -------------------------------------------------------------------------

// A cell with two points has children.
template <int D>
void WaitingTree<D>::Add(VertexIndex p) {
  Cell cell = {0, middle_, half_};
  for (int depth = 0;; ++depth) {
    Change(nodes_[cell.node], p, 1);
    if (nodes_[cell.node].children == kNone) {
      if (nodes_[cell.node].count == 1 || depth == kMostDepth) return;
      const VertexIndex other = nodes_[cell.node].all ^ p;
      nodes_[cell.node].children = static_cast<std::uint32_t>(nodes_.size());
      nodes_.resize(nodes_.size() + kChildren);
      Change(nodes_[Child(cell, ChildAt(cell, points_[other])).node], other, 1);
    }
    cell = Child(cell, ChildAt(cell, points_[p]));
  }
}

template <int D>
void WaitingTree<D>::Remove(VertexIndex p) {
  Cell cell = {0, middle_, half_};
  while (true) {
    Change(nodes_[cell.node], p, ~std::uint32_t{0});
    if (nodes_[cell.node].children == kNone) return;
    cell = Child(cell, ChildAt(cell, points_[p]));
  }
}

template <int D>
bool WaitingTree<D>::MayHavePoint(const Ball<D>& ball, double radius) {
  const double least_half = radius / 8;
  stack_.assign(1, {0, middle_, half_});
  while (!stack_.empty()) {
    const Cell cell = stack_.back();
    stack_.pop_back();
    const Node& node = nodes_[cell.node];
    if (node.count == 0) continue;
    if (node.count == 1) {
      if (geometry::SquaredDistance(points_[node.all], ball.centre) < radius * radius) return true;
      continue;
    }
    double d2 = 0;
    for (int k = 0; k < D; ++k) {
      const double d = std::max(0.0, std::fabs(ball.centre[k] - cell.middle[k]) - cell.half);
      d2 += d * d;
    }
    if (d2 > radius * radius) continue;
    if (node.children == kNone || cell.half < least_half) return true;
    for (std::size_t which = 0; which < kChildren; ++which) stack_.push_back(Child(cell, which));
  }
  return false;
}

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_WAITING_TREE_H_
