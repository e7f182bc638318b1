#include "core/meshing/sizing_field.h"

#include <algorithm>

namespace dynmesh::meshing {

template <int D>
bool SizingRegion<D>::Meets(const geometry::Point<D>& centre, double ball_radius) const {
  double d2 = 0;
  for (int i = 0; i < D; ++i) {
    const double d = std::max({lo[i] - centre[i], centre[i] - hi[i], 0.0});
    d2 += d * d;
  }
  const double reach = ball_radius + radius;
  if (d2 > reach * reach) return false;
  if constexpr (D == 2) return area == nullptr || area->Meets(centre, ball_radius);
  return true;
}

template <int D>
SizingField<D>::SizingField(const Point& lo, const Point& hi) : root_{0, {}, 0} {
  for (int k = 0; k < D; ++k) {
    root_.centre[k] = 0.5 * (lo[k] + hi[k]);
    root_.half = std::max(root_.half, hi[k] - lo[k]);
  }
  nodes_.emplace_back();
}

template <int D>
typename SizingField<D>::Cell SizingField<D>::Child(const Cell& cell, int quadrant,
                                                    std::uint32_t node) {
  Cell child{node, cell.centre, cell.half / 2};
  for (int k = 0; k < D; ++k)
    child.centre[k] += (quadrant >> k & 1) != 0 ? child.half : -child.half;
  return child;
}

template <int D>
typename SizingField<D>::Index SizingField<D>::Add(const Region& region) {
  Point centre;
  double widest = 0;
  for (int k = 0; k < D; ++k) {
    centre[k] = 0.5 * (region.lo[k] + region.hi[k]);
    widest = std::max(widest, region.hi[k] - region.lo[k]);
  }
  const double extent = 0.5 * widest + region.radius;
  const double size = std::max(extent, region.target);
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
  items_[index] = {region, cell.node, nodes_[cell.node].first};
  nodes_[cell.node].first = index;
  ++count_;
  UpdateLeast(cell.node);
  return index;
}

template <int D>
void SizingField<D>::Remove(Index index) {
  const std::uint32_t node = items_[index].node;
  std::uint32_t* link = &nodes_[node].first;
  while (*link != index) link = &items_[*link].next;
  *link = items_[index].next;
  free_items_.push_back(index);
  --count_;
  UpdateLeast(node);
}

template <int D>
std::uint32_t SizingField<D>::NewNode(std::uint32_t parent) {
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

// From a node whose items have changed up to the root; cells left empty go.
template <int D>
void SizingField<D>::UpdateLeast(std::uint32_t n) {
  while (n != kNone) {
    Node& node = nodes_[n];
    node.least = INFINITY;
    for (std::uint32_t i = node.first; i != kNone; i = items_[i].next) {
      node.least = std::min(node.least, items_[i].region.most_radius());
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

template <int D>
bool SizingField<D>::IsTooLarge(const Point& centre, double radius) const {
  std::array<Cell, (1 << D) * kMostDepth> stack;
  std::size_t top = 0;
  stack[top++] = root_;
  while (top > 0) {
    const Cell cell = stack[--top];
    const Node& node = nodes_[cell.node];
    if (!(node.least < radius)) continue;
    // What hangs in a cell reaches its side's length from its centre, and no farther; but
    // the root takes whatever is larger.
    const double reach = 2 * cell.half * (1 + 1e-9) + radius;
    bool beyond = false;
    for (int k = 0; k < D; ++k) beyond |= std::fabs(centre[k] - cell.centre[k]) > reach;
    if (cell.node != 0 && beyond) continue;
    for (std::uint32_t i = node.first; i != kNone; i = items_[i].next) {
      const Region& region = items_[i].region;
      if (region.most_radius() < radius && region.Meets(centre, radius)) return true;
    }
    for (int q = 0; q < 1 << D; ++q) {
      if (node.child[q] != kNone) stack[top++] = Child(cell, q, node.child[q]);
    }
  }
  return false;
}

template struct SizingRegion<2>;
template struct SizingRegion<3>;
template class SizingField<2>;
template class SizingField<3>;

}  // namespace dynmesh::meshing
