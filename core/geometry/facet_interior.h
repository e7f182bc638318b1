// Point-in-polygon tests in 3D, for at least as many queries as the polygon has corners.
//
// A point is inside if an odd number of rings goes around it. Seen along the plane's axis, its
// height has an odd number of edges to its right. Edges that span the same heights do not cross
// there, so they are ordered from left to right, and bisection finds how many are to the right.
// Each edge is stored at O(lg corners) nodes of a tree over the corners' heights (a segment tree:
// Bentley, Solutions to Klee's rectangle problems, 1977). Polygons with few corners need no tree.
//
// Everything is a function of the rings as chains, to the bit: it does not depend on a ring's first
// corner, its direction, or the order of rings. If rings cross, answers have no meaning but do no
// harm. Immutable, thread-safe. Construction O(corners lg corners), a query O(lg^2 corners).
#ifndef DYNMESH_CORE_GEOMETRY_FACET_INTERIOR_H_
#define DYNMESH_CORE_GEOMETRY_FACET_INTERIOR_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"

namespace dynmesh::geometry {

class FacetInterior {
 public:
  FacetInterior() = default;  // an empty interior
  // `plane`: the plane of the rings (PlaneOf).
  FacetInterior(std::span<const Ring3> rings, const FacetPlane& plane);

  // True if p, near the plane, is inside. Near an edge rounding decides.
  bool Holds(const Point3& p) const;
  // True if `direction`, in the plane, leads from `corner` into the inside. Along an edge rounding
  // decides.
  bool OpensTo(const Point3& corner, const Vector3& direction) const;

  std::size_t bytes() const {
    return edges_.capacity() * sizeof(Edge) + heights_.capacity() * sizeof(double) +
           (first_.capacity() + order_.capacity()) * sizeof(std::uint32_t);
  }

 private:
  // Seen along the axis: x to the right, y up. a is the lesser end in 3D.
  struct Edge {
    Point2 a, b;
  };

  Point2 Shadow(const Point3& p) const { return {{p[(axis_ + 1) % 3], p[(axis_ + 2) % 3]}}; }
  static double At(const Edge& e, double height);
  static bool IsLeftOf(const Point2& p, const Edge& e);
  static bool IsOrderedAtEnd(const Edge& e, const Edge& f);
  void MakeTree();
  template <class F>
  void ForEachNodeOf(const Edge& e, F f) const;
  void SortNode(std::uint32_t node);
  template <class IsLeft>
  bool IsOdd(double height, bool below, IsLeft is_left) const;

  int axis_ = 0;
  std::vector<Edge> edges_;
  // The tree, if there are many edges. Leaf i is between heights_[i] and heights_[i + 1]. Nodes are
  // numbered as in a heap, from 1 on.
  std::vector<double> heights_;               // of corners, ascending, each once
  std::uint32_t leaves_ = 0;                  // a power of two
  std::vector<std::uint32_t> first_, order_;  // by node: its edges from left to right
};

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_FACET_INTERIOR_H_
