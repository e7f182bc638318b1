// A polyline as a region: does a ball meet it? With the radius of SizingRegion around it, that is a
// capsule. A hierarchy of boxes over the edges.
//
// Computed in doubles. Answers are a function of the set of edges to the bit, whatever the
// hierarchy is: neither the polyline's direction nor duplicate edges change one. Immutable,
// thread-safe. O(log edges + edges near the ball).
#ifndef DYNMESH_CORE_MESHING_POLYLINE_H_
#define DYNMESH_CORE_MESHING_POLYLINE_H_

#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/edge_tree.h"
#include "core/meshing/sizing_shape.h"

namespace dynmesh::meshing {

template <int D>
class Polyline : public SizingShape<D> {
 public:
  using Point = geometry::Point<D>;

  // REQUIRES: two vertices or more. Edges may have length 0, overlap and cross. O(n log n).
  explicit Polyline(std::span<const Point> vertices);

  bool Meets(const Point& centre, double radius) const override;
  bool Holds(const Point& centre, double radius, double reach) const override {
    return radius <= reach && Meets(centre, reach - radius);
  }
  const Point& lo() const { return edges_.lo(); }
  const Point& hi() const { return edges_.hi(); }

 private:
  using Edge = typename EdgeTree<D>::Edge;  // the lesser end first
  static std::vector<Edge> EdgesOf(std::span<const Point> vertices);

  EdgeTree<D> edges_;
};

// The square of the distance of x from the edge ab, a <= b, as computed here: never less than that
// of any box around the edge.
template <int D>
double SquaredDistanceToEdge(const geometry::Point<D>& x, const geometry::Point<D>& a,
                             const geometry::Point<D>& b);

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_POLYLINE_H_
