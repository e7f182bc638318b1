// The inside of rings as a 2D region: does a ball meet it? A hierarchy of boxes over the edges. A
// point is inside if an odd number of rings goes around it.
//
// Computed in doubles, not exact near the border. But answers are functions of the rings as sets of
// edges: neither a ring's first point nor its direction changes a bit. The side of an edge rounds
// otherwise than in geometry/facet_interior.h, and meshes depend on both. Immutable, thread-safe.
// O(log edges + edges near the ball or to the right of its centre).
#ifndef DYNMESH_CORE_MESHING_POLYGON_AREA_H_
#define DYNMESH_CORE_MESHING_POLYGON_AREA_H_

#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/edge_tree.h"
#include "core/meshing/sizing_shape.h"

namespace dynmesh::meshing {

class PolygonArea : public SizingShape<2> {
 public:
  // Each ring has at least three points; the last is joined to the first.
  explicit PolygonArea(std::span<const std::vector<geometry::Point2>> rings);

  bool Meets(const geometry::Point2& centre, double radius) const override;
  bool Holds(const geometry::Point2& centre, double radius, double reach) const override;
  const geometry::Point2& lo() const { return edges_.lo(); }
  const geometry::Point2& hi() const { return edges_.hi(); }

 private:
  using Edge = EdgeTree<2>::Edge;  // the lower end first
  static std::vector<Edge> EdgesOf(std::span<const std::vector<geometry::Point2>> rings);
  static double SquaredDistance(const Edge& edge, const geometry::Point2& p);
  // Is an edge within `radius` of the centre? If none is, *inside: is the centre inside?
  bool IsNearEdge(const geometry::Point2& centre, double radius, bool* inside) const;

  EdgeTree<2> edges_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_POLYGON_AREA_H_
