// The inside of rings as a 2D region: does a ball meet it? A hierarchy of boxes over the edges. A
// point is inside if an odd number of rings goes around it.
//
// Computed in doubles, not exact near the border. But answers are functions of the rings as sets of
// edges: neither a ring's first point nor its direction changes a bit. The side of an edge rounds
// otherwise than in geometry/facet_interior.h, and meshes depend on both. Immutable, thread-safe.
// O(log edges + edges near the ball or to the right of its centre).
#ifndef DYNMESH_CORE_MESHING_POLYGON_AREA_H_
#define DYNMESH_CORE_MESHING_POLYGON_AREA_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::meshing {

class PolygonArea {
 public:
  // Each ring has at least three points; the last is joined to the first.
  explicit PolygonArea(std::span<const std::vector<geometry::Point2>> rings);

  bool Meets(const geometry::Point2& centre, double radius) const;
  const geometry::Point2& lo() const { return nodes_.front().lo; }
  const geometry::Point2& hi() const { return nodes_.front().hi; }

 private:
  struct Edge {
    geometry::Point2 a, b;  // the lower first
  };
  // A box over edges [first, last). An inner node's first child is the next node.
  struct Node {
    geometry::Point2 lo, hi;
    std::uint32_t first, last;
    std::uint32_t second_child;  // 0: a leaf
  };

  std::uint32_t Build(std::uint32_t first, std::uint32_t last);
  static double SquaredDistance(const Edge& edge, const geometry::Point2& p);

  std::vector<Edge> edges_;
  std::vector<Node> nodes_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_POLYGON_AREA_H_
