// A bucket quadtree / octree over points. It finds the vertices near a position. Its nodes are the
// *places* of the self-adjusting engine, where operations subscribe to changes.
//
// It is the thesis's quadtree with relaxed crowding: a leaf holds up to 16 points instead of
// one. The queries are the same, with an order of magnitude fewer cells. It stands outside the time
// of the trace; queries filter by birth. Its shape is a function of the present points, but for
// leaves that subscribers have split or keep apart, which depends on the order of edits. So no
// output of an operation may depend on its shape.
//
// Thread-compatible. Node 0 is the root. Removal merges leaves and reports each merge by on_merge.
#ifndef DYNMESH_CORE_MESHING_SPATIAL_TREE_H_
#define DYNMESH_CORE_MESHING_SPATIAL_TREE_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/large_vector.h"
#include "core/base/rounding.h"
#include "core/geometry/point.h"
#include "core/meshing/extent.h"
#include "core/meshing/leaf_chains.h"

namespace dynmesh::meshing {

template <int D>
class SpatialTree {
 public:
  using Point = geometry::Point<D>;
  using NodeIndex = std::uint32_t;
  static constexpr int kChildren = 1 << D;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  using Ball = meshing::Ball<D>;

  // Covers the box [lo, hi] by a cube. Its side is a power of two and its centre a round number, so
  // that the borders of cells are exact. Cells are half-open: a point on a border belongs to the
  // upper cell.
  SpatialTree(const Point& lo, const Point& hi) {
    double side = 0, largest = 0;
    for (int i = 0; i < D; ++i) {
      side = std::max(side, hi[i] - lo[i]);
      largest = std::max({largest, std::fabs(lo[i]), std::fabs(hi[i])});
    }
    const double grain = std::ldexp(1.0, std::ilogb(side) - 2);
    half_ = 8 * grain;
    least_half_ = std::ldexp(1.0, std::ilogb(largest) - 48);
    for (int i = 0; i < D; ++i) centre_[i] = grain * std::nearbyint((lo[i] + hi[i]) / 2 / grain);
    nodes_.push_back({kNone, kNone, kNone});
  }

  void Insert(std::uint32_t id, const Point& p) {
    Cell cell = LeafOf(p);
    while (leaves_.IsFull(nodes_[cell.node].leaves) && cell.half > least_half_) {
      Split(cell.node, cell);
      Descend(p, cell);
    }
    leaves_.Append(nodes_[cell.node].leaves, id, p);
  }

  // Removes a point. Leaves with few points merge if may_merge(their first node, parent).
  // on_merge(first node, parent) is called for each merge, before the nodes are freed. REQUIRES: it
  // was inserted with that id and point.
  template <class MayMerge, class OnMerge>
  void Remove(std::uint32_t id, const Point& p, MayMerge may_merge, OnMerge on_merge) {
    Cell cell = LeafOf(p);
    leaves_.Remove(nodes_[cell.node].leaves, id);
    for (NodeIndex n = nodes_[cell.node].parent; n != kNone; n = nodes_[n].parent) {
      if (!TryMerge(n, may_merge, on_merge)) break;
    }
  }

  // The same where nothing depends on the nodes.
  void Remove(std::uint32_t id, const Point& p) {
    Remove(
        id, p, [](NodeIndex, NodeIndex) { return true; }, [](NodeIndex, NodeIndex) {});
  }

  // Calls visit(id, point, squared distance) for each point in the ball; visit may shrink
  // `radius2`.
  template <class Visit>
  void VisitBall(const Point& centre, double& radius2, Visit visit) const {
    Cell stack[kStack];
    int top = 0;
    stack[top++] = SmallestAround(centre, radius2);
    while (top > 0) {
      const Cell cell = stack[--top];
      if (DistanceToCell2(centre, cell) > radius2) continue;
      const Node& node = nodes_[cell.node];
      if (node.child == kNone) {
        leaves_.ForEach(node.leaves, [&](std::uint32_t id, const Point& p) {
          const double d2 = geometry::SquaredDistance(p, centre);
          if (d2 <= radius2) visit(id, p, d2);
        });
        continue;
      }
      // Nearest child on top.
      const int near = Quadrant(centre, cell);
      for (int k = kChildren - 1; k >= 0; --k) stack[top++] = Child(cell, near ^ k);
    }
  }

  // Calls visit(id, point) for each point in one of the balls. The balls lie in the box. Returns
  // false as soon as it has looked at more than `most` points. Uses room behind the balls as
  // scratch.
  template <class Visit>
  bool VisitBalls(std::vector<Ball>& balls, const Extent<D>& box, int most, Visit visit) const {
    // A cell, and the part of the vector with the balls that its parent meets. Balls behind that
    // part belong to finished cells.
    struct Entry {
      Cell cell;
      std::size_t begin, end;
    };
    Entry stack[kStack];
    int top = 0;
    stack[top++] = {SmallestAround(box), 0, balls.size()};
    while (top > 0) {
      auto [cell, begin, end] = stack[--top];
      const Node& node = nodes_[cell.node];
      if constexpr (D > 2) {
        // Without branches, which would be mispredicted.
        balls.resize(end + (end - begin));
        std::size_t next = end;
        for (std::size_t i = begin; i < end; ++i) {
          balls[next] = balls[i];
          next += DistanceToCell2(balls[i].centre, cell) <= balls[i].radius2 ? 1 : 0;
        }
        begin = end;
        end = next;
        if (begin == end) continue;
      }
      if (node.child == kNone) {
        const std::span<const Ball> near(balls.data() + begin, end - begin);
        if (!leaves_.VisitBalls(node.leaves, near, box, &most, visit)) return false;
        continue;
      }
      // clang 14 does not capture structured bindings by themselves.
      ForEachChildIn(box, cell, [&, begin = begin, end = end](const Cell& child) {
        if (const Node& n = nodes_[child.node]; n.child == kNone) {
          if (n.leaves == kNone) return;
          leaves_.Prefetch(n.leaves);
        }
        stack[top++] = {child, begin, end};
      });
    }
    return true;
  }

  static constexpr int kSlabs = 32 / D;
  // Visits the nodes on the path from the root to the leaf of p, each with p's *part* of its cell.
  // Along each axis a cell is cut into kSlabs slabs. Parts are a bit for each slab of each axis. A
  // box holds p only if the bits of its slabs include those of p.
  template <class Visit>
  void VisitPath(const Point& p, Visit visit) const {
    Cell cell = Root();
    visit(cell.node, PartsOf({p.c, p.c}, cell));
    while (nodes_[cell.node].child != kNone) {
      cell = Child(cell, Quadrant(p, cell));
      visit(cell.node, PartsOf({p.c, p.c}, cell));
    }
  }

  // Visits every node with a cell that meets the box, ancestors included, without the cells for
  // which keep(centre, half the side) is false, and those below them.
  template <class Keep, class Visit>
  void VisitBoxIf(const Extent<D>& box, Keep keep, Visit visit) const {
    Cell stack[kStack];
    int top = 0;
    if (Meets(box, Root())) stack[top++] = Root();
    while (top > 0) {
      const Cell cell = stack[--top];
      if (!keep(cell.centre, cell.half)) continue;
      visit(cell.node);
      if (nodes_[cell.node].child != kNone) PushChildrenIn(box, cell, stack, top);
    }
  }

  // Visits every node with a cell that meets the closed ball, ancestors included. Conservative: may
  // visit a cell that the ball misses by rounding.
  template <class Visit>
  void VisitCells(const Ball& ball, Visit visit) const {
    Extent<D> box = Extent<D>::Nothing();
    box.AddBall(ball.centre, std::sqrt(ball.radius2) * kRootWider);
    VisitBoxIf(
        box,
        [&](const Point& centre, double half) {
          return DistanceToCell2(ball.centre, {0, centre, half}) <= ball.radius2;
        },
        visit);
  }

  // Visits a few nodes (2^D unless the box extends beyond the tree). Their cells together cover the
  // part of the box inside the tree. Each cell is no smaller than the box, or a leaf. So any point
  // of the box has one of the nodes on its path. Each node comes with the box's parts of its cell.
  template <class Visit>
  void Cover(const Extent<D>& box, Visit visit) const {
    CoverAndSplit(
        box, [](const Cell&) { return false; }, visit);
  }

  // The same for a box that is kept at those nodes. Beside a row of points there may be a leaf as
  // large as the domain and without any: it would keep the boxes of the whole row. So a leaf is
  // split if it is larger than the box and is_crowded(node).
  template <class IsCrowded, class Visit>
  void CoverToKeep(const Extent<D>& box, IsCrowded is_crowded, Visit visit) {
    const auto split = [&](const Cell& cell) {
      if (!(cell.half > least_half_) || !is_crowded(cell.node)) return false;
      Split(cell.node, cell);
      return true;
    };
    CoverAndSplit(box, split, visit);
  }

  void Reserve(std::size_t points) {
    nodes_.reserve(points);
    leaves_.Reserve(points / 2);
  }
  std::size_t node_count() const { return nodes_.size() - kChildren * free_nodes_.size(); }
  std::size_t bytes() const { return nodes_.size() * sizeof(Node) + leaves_.bytes(); }

 private:
  using Leaves = LeafChains<D>;
  static constexpr int kStack = 16 + 64 * (kChildren - 1) * 2;

  struct Node {
    std::uint32_t child;   // first of kChildren consecutive nodes, or kNone
    std::uint32_t leaves;  // a chain; kNone if it has children or is empty, as most around curves
    NodeIndex parent;
  };
  struct Cell {
    NodeIndex node;
    Point centre;
    double half;
  };

  Cell Root() const { return {0, centre_, half_}; }

  // Points outside of the cell count as in its outermost slabs.
  static std::uint32_t PartsOf(const Extent<D>& box, const Cell& cell) {
    const double slabs = kSlabs / (2 * cell.half);
    std::uint32_t parts = 0;
    for (int k = 0; k < D; ++k) {
      const double low = cell.centre[k] - cell.half;
      // Rounds points and boxes alike, so that their order is kept. NaN counts as 0.
      const auto slab = [&](double x) {
        const double at = (x - low) * slabs;
        const double from_0 = at > 0 ? at : 0;  // one instruction each, unlike std::max
        return static_cast<int>(from_0 < kSlabs - 1.0 ? from_0 : kSlabs - 1.0);
      };
      const std::uint32_t up_to = (std::uint32_t{2} << slab(box.hi[k])) - 1,
                          below = (std::uint32_t{1} << slab(box.lo[k])) - 1;
      parts |= (up_to & ~below) << (k * kSlabs);
    }
    return parts;
  }

  static int Quadrant(const Point& p, const Cell& cell) {
    int q = 0;
    for (int i = 0; i < D; ++i) q |= (p[i] >= cell.centre[i] ? 1 : 0) << i;
    return q;
  }
  Cell Child(const Cell& cell, int q) const {
    Cell c{nodes_[cell.node].child + static_cast<NodeIndex>(q), cell.centre, cell.half / 2};
    const double steps[2] = {-c.half, c.half};  // looked up without a branch
    for (int i = 0; i < D; ++i) c.centre[i] += steps[q >> i & 1];
    return c;
  }
  Cell LeafOf(const Point& p) const {
    Cell cell = SharedByPrefix(p, p, 0);
    Descend(p, cell);
    return cell;
  }
  void Descend(const Point& p, Cell& cell) const {
    while (nodes_[cell.node].child != kNone) cell = Child(cell, Quadrant(p, cell));
  }
  // The smallest cell that contains the part of the ball inside the tree.
  Cell SmallestAround(const Point& centre, double radius2) const {
    if (!(radius2 < half_ * half_)) return Root();
    const double r = std::sqrt(radius2) * kRootWider;
    Extent<D> box{centre.c, centre.c};
    for (int i = 0; i < D; ++i) {
      const double rounding = std::fabs(centre[i]) * 0x1p-52;
      box.lo[i] -= r + rounding;
      box.hi[i] += r + rounding;
    }
    return SmallestAround(box);
  }
  // The smallest cell that contains the part of the box inside the tree, of those with half >=
  // least_half or no smaller cell.
  Cell SmallestAround(const Extent<D>& box, double least_half = 0) const {
    const Point lo{box.lo}, hi{box.hi};
    Cell cell = SharedByPrefix(lo, hi, least_half);
    while (nodes_[cell.node].child != kNone && cell.half >= least_half) {
      const int q = Quadrant(lo, cell);
      if (q != Quadrant(hi, cell)) break;
      cell = Child(cell, q);
    }
    return cell;
  }
  // A cell that contains all between lo and hi, and nearly the smallest one: the cell of the
  // leading bits that their coordinates share, counted in 2^-30 of the root. Rounding moves a count
  // by less than one, so counts are taken one farther out.
  Cell SharedByPrefix(const Point& lo, const Point& hi, double least_half) const {
    constexpr int kLevels = 30;
    constexpr double kMost = (1 << kLevels) - 1;
    const double per_length = (1 << (kLevels - 1)) / half_;
    std::array<std::uint32_t, D> at;
    std::uint32_t differ = 0;
    for (int i = 0; i < D; ++i) {
      const double from = centre_[i] - half_;
      at[i] = static_cast<std::uint32_t>(std::clamp((lo[i] - from) * per_length - 1, 0.0, kMost));
      differ |= at[i] ^
                static_cast<std::uint32_t>(std::clamp((hi[i] - from) * per_length + 1, 0.0, kMost));
    }
    const int shared = kLevels - std::bit_width(differ);
    Cell cell = Root();
    int depth = 0;
    while (depth < shared && nodes_[cell.node].child != kNone && cell.half >= least_half) {
      ++depth;
      std::uint32_t q = 0;
      for (int i = 0; i < D; ++i) q |= (at[i] >> (kLevels - depth) & 1) << i;
      cell.node = nodes_[cell.node].child + q;
      cell.half /= 2;
    }
    for (int i = 0; i < D; ++i) {
      const double cells = at[i] >> (kLevels - depth);
      cell.centre[i] = (centre_[i] - half_) + (2 * cells + 1) * cell.half;
    }
    return cell;
  }
  // Squared distance from p to the closed cell, rounded down: at most what is computed for any
  // point in the cell. Points beyond the root's border would belong to its outermost cells, but
  // there are none.
  static double DistanceToCell2(const Point& p, const Cell& cell) {
    const double half = cell.half * (1 + 0x1p-50);
    double d2 = 0;
    for (int i = 0; i < D; ++i) {
      const double beyond = std::fabs(p[i] - cell.centre[i]) - half;
      const double d = beyond + std::fabs(beyond);  // 2 * beyond, or 0 if negative, without a
                                                    // branch
      d2 += d * d;
    }
    return d2 * (0.25 * (1 - 0x1p-50));
  }
  // Calls f(child) for the children of the cell that meet the box. REQUIRES: the cell meets it.
  template <class F>
  void ForEachChildIn(const Extent<D>& box, const Cell& cell, F f) const {
    int low = 0, high = 0;  // axes along which the lower or upper half meets it
    for (int i = 0; i < D; ++i) {
      low |= (box.lo[i] < cell.centre[i]) << i;
      high |= (box.hi[i] >= cell.centre[i]) << i;
    }
    for (int k = 0; k < kChildren; ++k) {
      if (((k & high) | (~k & low)) == kChildren - 1) f(Child(cell, k));
    }
  }
  // `split(leaf)`, of a leaf that is no smaller than the box: true if it has split it.
  template <class SplitLeaf, class Visit>
  void CoverAndSplit(const Extent<D>& box, SplitLeaf split, Visit visit) const {
    double side = 0;
    for (int i = 0; i < D; ++i) side = std::max(side, box.hi[i] - box.lo[i]);
    Cell stack[kStack];
    int top = 0;
    stack[top++] = SmallestAround(box, side);
    while (top > 0) {
      const Cell cell = stack[--top];
      if (cell.half < side || (nodes_[cell.node].child == kNone && !split(cell))) {
        visit(cell.node, PartsOf(box, cell));
        continue;
      }
      PushChildrenIn(box, cell, stack, top);
    }
  }
  void PushChildrenIn(const Extent<D>& box, const Cell& cell, Cell* stack, int& top) const {
    ForEachChildIn(box, cell, [&](const Cell& child) { stack[top++] = child; });
  }
  static bool Meets(const Extent<D>& box, const Cell& cell) {
    for (int i = 0; i < D; ++i) {
      if (box.lo[i] >= cell.centre[i] + cell.half || box.hi[i] < cell.centre[i] - cell.half) {
        return false;
      }
    }
    return true;
  }

  void Split(NodeIndex n, const Cell& cell) {
    NodeIndex first;
    if (free_nodes_.empty()) {
      first = static_cast<NodeIndex>(nodes_.size());
      nodes_.resize(nodes_.size() + kChildren);
    } else {
      first = free_nodes_.back();
      free_nodes_.pop_back();
    }
    const std::uint32_t old = nodes_[n].leaves;
    nodes_[n].child = first;
    nodes_[n].leaves = kNone;
    for (int k = 0; k < kChildren; ++k) nodes_[first + k] = {kNone, kNone, n};
    if (old == kNone) return;
    leaves_.MoveAll(old, [&](const Point& p) -> std::uint32_t& {
      return nodes_[first + Quadrant(p, cell)].leaves;
    });
  }

  template <class MayMerge, class OnMerge>
  bool TryMerge(NodeIndex n, MayMerge may_merge, OnMerge on_merge) {
    const NodeIndex first = nodes_[n].child;
    std::uint32_t sum = 0;
    for (int k = 0; k < kChildren; ++k) {
      const Node& c = nodes_[first + k];
      // Its children may have been kept apart, and need not be any longer.
      if (c.child != kNone && !TryMerge(first + k, may_merge, on_merge)) return false;
      if (c.leaves == kNone) continue;
      if (leaves_.IsLong(c.leaves)) return false;
      sum += leaves_.CountOfFirst(c.leaves);
    }
    if (sum > Leaves::kCapacity / 2 || !may_merge(first, n)) return false;
    on_merge(first, n);
    nodes_[n].child = kNone;
    for (int k = 0; k < kChildren; ++k) {
      const std::uint32_t old = nodes_[first + k].leaves;
      if (old == kNone) continue;
      leaves_.MoveAll(old, [&](const Point&) -> std::uint32_t& { return nodes_[n].leaves; });
    }
    free_nodes_.push_back(first);
    return true;
  }

  Point centre_;
  double half_;
  double least_half_;  // smaller cells would not have exact borders
  LargeVector<Node> nodes_;
  Leaves leaves_;
  std::vector<NodeIndex> free_nodes_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPATIAL_TREE_H_
