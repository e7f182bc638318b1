#include "core/meshing/sizing_field.h"

#include <algorithm>

namespace dynmesh::meshing {

using geometry::Point2;

bool SizingRegion::Meets(const Point2& centre, double ball_radius) const {
  double d2 = 0;
  for (int i = 0; i < 2; ++i) {
    const double d = std::max({lo[i] - centre[i], centre[i] - hi[i], 0.0});
    d2 += d * d;
  }
  const double reach = ball_radius + radius;
  return d2 <= reach * reach && (area == nullptr || area->Meets(centre, ball_radius));
}

SizingField::SizingField(const Point2& lo, const Point2& hi)
    : root_{0,
            {{0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])}},
            std::max(hi[0] - lo[0], hi[1] - lo[1])} {
  nodes_.emplace_back();
}

SizingField::Cell SizingField::Child(const Cell& cell, int quadrant, std::uint32_t node) {
  const double half = cell.half / 2;
  return {node,
          {{cell.centre[0] + (quadrant & 1 ? half : -half),
            cell.centre[1] + (quadrant & 2 ? half : -half)}},
          half};
}

SizingField::Index SizingField::Add(const SizingRegion& region) {
  const Point2 centre{{0.5 * (region.lo[0] + region.hi[0]), 0.5 * (region.lo[1] + region.hi[1])}};
  const double extent =
      0.5 * std::max(region.hi[0] - region.lo[0], region.hi[1] - region.lo[1]) + region.radius;
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

void SizingField::Remove(Index index) {
  const std::uint32_t node = items_[index].node;
  std::uint32_t* link = &nodes_[node].first;
  while (*link != index) link = &items_[*link].next;
  *link = items_[index].next;
  free_items_.push_back(index);
  --count_;
  UpdateLeast(node);
}

std::uint32_t SizingField::NewNode(std::uint32_t parent) {
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
void SizingField::UpdateLeast(std::uint32_t n) {
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

bool SizingField::IsTooLarge(const Point2& centre, double radius) const {
  std::array<Cell, 4 * kMostDepth> stack;
  std::size_t top = 0;
  stack[top++] = root_;
  while (top > 0) {
    const Cell cell = stack[--top];
    const Node& node = nodes_[cell.node];
    if (!(node.least < radius)) continue;
    // What hangs in a cell reaches its side's length from its centre, and no farther; but
    // the root takes whatever is larger.
    const double reach = 2 * cell.half * (1 + 1e-9) + radius;
    if (cell.node != 0 && (std::fabs(centre[0] - cell.centre[0]) > reach ||
                           std::fabs(centre[1] - cell.centre[1]) > reach)) {
      continue;
    }
    for (std::uint32_t i = node.first; i != kNone; i = items_[i].next) {
      const SizingRegion& region = items_[i].region;
      if (region.most_radius() < radius && region.Meets(centre, radius)) return true;
    }
    for (int q = 0; q < 4; ++q) {
      if (node.child[q] != kNone) stack[top++] = Child(cell, q, node.child[q]);
    }
  }
  return false;
}

}  // namespace dynmesh::meshing
