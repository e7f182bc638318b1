#include "core/meshing/polygon_area.h"

#include <algorithm>
#include <cmath>

#include "core/base/rings.h"

namespace dynmesh::meshing {

using geometry::Point2;

PolygonArea::PolygonArea(std::span<const std::vector<Point2>> rings) {
  ForEachEdgeOf(rings, [this](const Point2& p, const Point2& q) {
    const bool p_lower = p[1] < q[1] || (p[1] == q[1] && p[0] < q[0]);
    edges_.push_back(p_lower ? Edge{p, q} : Edge{q, p});
  });
  Build(0, static_cast<std::uint32_t>(edges_.size()));
}

std::uint32_t PolygonArea::Build(std::uint32_t first, std::uint32_t last) {
  constexpr std::uint32_t kLeaf = 4;
  Node node{edges_[first].a, edges_[first].a, first, last, 0};
  for (std::uint32_t i = first; i < last; ++i) {
    for (const Point2& p : {edges_[i].a, edges_[i].b}) {
      for (int axis = 0; axis < 2; ++axis) {
        node.lo[axis] = std::min(node.lo[axis], p[axis]);
        node.hi[axis] = std::max(node.hi[axis], p[axis]);
      }
    }
  }
  const auto at = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back(node);
  if (last - first <= kLeaf) return at;
  const int axis = node.hi[0] - node.lo[0] > node.hi[1] - node.lo[1] ? 0 : 1;
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(edges_.begin() + first, edges_.begin() + middle, edges_.begin() + last,
                   [axis](const Edge& s, const Edge& t) {
                     return s.a[axis] + s.b[axis] < t.a[axis] + t.b[axis];
                   });
  Build(first, middle);
  const std::uint32_t second = Build(middle, last);
  nodes_[at].second_child = second;
  return at;
}

double PolygonArea::SquaredDistance(const Edge& edge, const Point2& p) {
  const double dx = edge.b[0] - edge.a[0], dy = edge.b[1] - edge.a[1];
  const double px = p[0] - edge.a[0], py = p[1] - edge.a[1];
  const double length2 = dx * dx + dy * dy;
  const double along = std::clamp(dx * px + dy * py, 0.0, length2);
  const double t = length2 > 0 ? along / length2 : 0;
  const double ex = px - t * dx, ey = py - t * dy;
  return ex * ex + ey * ey;
}

bool PolygonArea::Meets(const Point2& centre, double radius) const {
  const double radius2 = radius * radius;
  bool inside = false;
  std::uint32_t stack[64] = {0};
  int top = 1;
  while (top > 0) {
    const std::uint32_t at = stack[--top];
    const Node& node = nodes_[at];
    const double dx = std::max({node.lo[0] - centre[0], centre[0] - node.hi[0], 0.0});
    const double dy = std::max({node.lo[1] - centre[1], centre[1] - node.hi[1], 0.0});
    const bool may_be_near = dx * dx + dy * dy <= radius2;
    const bool may_be_crossed = dy == 0 && centre[0] <= node.hi[0];
    if (!may_be_near && !may_be_crossed) continue;
    if (node.second_child != 0) {
      stack[top++] = node.second_child;
      stack[top++] = at + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.last; ++i) {
      const Edge& e = edges_[i];
      if (may_be_near && SquaredDistance(e, centre) <= radius2) return true;
      if ((e.a[1] <= centre[1]) == (e.b[1] <= centre[1])) continue;
      const double side =
          (e.b[0] - e.a[0]) * (centre[1] - e.a[1]) - (e.b[1] - e.a[1]) * (centre[0] - e.a[0]);
      inside ^= side > 0;
    }
  }
  return inside;
}

}  // namespace dynmesh::meshing
