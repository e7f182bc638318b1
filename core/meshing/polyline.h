// A polyline as a region: does a ball meet it? With the radius of SizingRegion around it, that is a
// capsule. A hierarchy of boxes over the pieces.
//
// Computed in doubles. Answers are a function of the set of pieces to the bit, whatever the
// hierarchy is: neither the polyline's direction nor duplicate pieces change one. Immutable,
// thread-safe. O(log pieces + pieces near the ball).
#ifndef DYNMESH_CORE_MESHING_POLYLINE_H_
#define DYNMESH_CORE_MESHING_POLYLINE_H_

#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/edge_tree.h"
#include "core/meshing/region_shape.h"

namespace dynmesh::meshing {

template <int D>
class Polyline : public RegionShape<D> {
 public:
  using Point = geometry::Point<D>;

  // REQUIRES: two vertices or more. Pieces may have length 0, overlap and cross. O(n log n).
  explicit Polyline(std::span<const Point> vertices);

  bool Meets(const Point& centre, double radius) const override;
  const Point& lo() const { return pieces_.lo(); }
  const Point& hi() const { return pieces_.hi(); }

 private:
  using Piece = typename EdgeTree<D>::Edge;  // the lesser end first
  static std::vector<Piece> PiecesOf(std::span<const Point> vertices);

  EdgeTree<D> pieces_;
};

// The square of the distance of x from the piece ab, a <= b, as computed here: never less than that
// of any box around the piece.
template <int D>
double SquaredDistanceToPiece(const geometry::Point<D>& x, const geometry::Point<D>& a,
                              const geometry::Point<D>& b);

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_POLYLINE_H_
