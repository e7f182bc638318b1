#include "core/meshing/polygon_area.h"

#include <algorithm>
#include <cmath>

#include "core/base/rings.h"

namespace dynmesh::meshing {

using geometry::Point2;

PolygonArea::PolygonArea(std::span<const std::vector<Point2>> rings) : edges_(EdgesOf(rings)) {}

std::vector<PolygonArea::Edge> PolygonArea::EdgesOf(std::span<const std::vector<Point2>> rings) {
  std::vector<Edge> edges;
  ForEachEdgeOf(rings, [&](const Point2& p, const Point2& q) {
    const bool p_lower = p[1] < q[1] || (p[1] == q[1] && p[0] < q[0]);
    edges.push_back(p_lower ? Edge{p, q} : Edge{q, p});
  });
  return edges;
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
  bool inside = false;
  return IsNearEdge(centre, radius, &inside) || inside;
}

bool PolygonArea::Holds(const Point2& centre, double radius, double reach) const {
  if (radius <= reach) return Meets(centre, reach - radius);
  bool inside = false;
  return !IsNearEdge(centre, radius - reach, &inside) && inside;
}

bool PolygonArea::IsNearEdge(const Point2& centre, double radius, bool* inside) const {
  const double radius2 = radius * radius;
  bool is_inside = false, may_be_near = false;
  const bool near = edges_.Visit(
      [&](const Point2& lo, const Point2& hi) {
        const double dx = std::max({lo[0] - centre[0], centre[0] - hi[0], 0.0});
        const double dy = std::max({lo[1] - centre[1], centre[1] - hi[1], 0.0});
        may_be_near = dx * dx + dy * dy <= radius2;
        const bool may_be_crossed = dy == 0 && centre[0] <= hi[0];
        return may_be_near || may_be_crossed;
      },
      [&](std::span<const Edge> edges) {
        for (const Edge& e : edges) {
          if (may_be_near && SquaredDistance(e, centre) <= radius2) return true;
          if ((e.a[1] <= centre[1]) == (e.b[1] <= centre[1])) continue;
          const double side =
              (e.b[0] - e.a[0]) * (centre[1] - e.a[1]) - (e.b[1] - e.a[1]) * (centre[0] - e.a[0]);
          is_inside ^= side > 0;
        }
        return false;
      });
  *inside = is_inside;
  return near;
}

}  // namespace dynmesh::meshing
