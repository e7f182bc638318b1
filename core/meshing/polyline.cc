#include "core/meshing/polyline.h"

#include <algorithm>

#include "core/geometry/segment_distance.h"

namespace dynmesh::meshing {

using geometry::Point;

template <int D>
double SquaredDistanceToEdge(const Point<D>& x, const Point<D>& a, const Point<D>& b) {
  Point<D> foot = geometry::NearestOn(x, a, b);
  for (int k = 0; k < D; ++k) {
    // Rounding must not take it out of the edge's box.
    foot[k] = std::clamp(foot[k], std::min(a[k], b[k]), std::max(a[k], b[k]));
  }
  return geometry::SquaredDistance(x, foot);
}

template <int D>
Polyline<D>::Polyline(std::span<const Point> vertices) : edges_(EdgesOf(vertices)) {}

template <int D>
std::vector<typename Polyline<D>::Edge> Polyline<D>::EdgesOf(std::span<const Point> vertices) {
  std::vector<Edge> edges;
  edges.reserve(vertices.size() - 1);
  for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
    const Point &p = vertices[i], &q = vertices[i + 1];
    edges.push_back(p < q ? Edge{p, q} : Edge{q, p});
  }
  return edges;
}

template <int D>
bool Polyline<D>::Meets(const Point& centre, double radius) const {
  const double radius2 = radius * radius;
  return edges_.Visit(
      [&](const Point& lo, const Point& hi) {
        double d2 = 0;
        for (int k = 0; k < D; ++k) {
          const double d = std::max({lo[k] - centre[k], centre[k] - hi[k], 0.0});
          d2 += d * d;
        }
        return d2 <= radius2;
      },
      [&](std::span<const Edge> edges) {
        return std::ranges::any_of(edges, [&](const Edge& edge) {
          return SquaredDistanceToEdge(centre, edge.a, edge.b) <= radius2;
        });
      });
}

template class Polyline<2>;
template class Polyline<3>;
template double SquaredDistanceToEdge(const Point<2>&, const Point<2>&, const Point<2>&);
template double SquaredDistanceToEdge(const Point<3>&, const Point<3>&, const Point<3>&);

}  // namespace dynmesh::meshing
