// The intersection of a vertex's Voronoi cell with a facet.
//
// Where the vertices of a facet are dense enough, the cells of other vertices do not meet it:
// 1. Every point of the facet is then nearest to a vertex of the facet.
// 2. The triangles that these vertices span there have empty balls with centres in the facet. So
//    they are in the triangulation.
// 3. Subsegments have empty balls already. So the cell of another vertex does not reach the facet's
//    border: its intersection with the facet's plane is either entirely inside the facet or
//    entirely outside.
//
// The result is a function of the star's set of neighbours and of the facet, to the bit. One object
// is used for many stars: no allocation once warm. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_CELL_CUT_H_
#define DYNMESH_CORE_MESHING_CELL_CUT_H_

#include <array>
#include <optional>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/facet_field.h"
#include "core/meshing/space_star.h"

namespace dynmesh::meshing {

class CellCut {
 public:
  // Selects the star. It must not change while it is used.
  void Begin(const SpaceStar& star);

  struct Cut {
    geometry::Point3 nearest = {};  // the intersection's point nearest to the vertex
    double distance2 = 0;           // its squared distance from the vertex
    // The cell only touches the facet, within rounding. Then the facet is missing from the
    // triangulation only if an edge from the vertex to a neighbour on the facet's far side goes
    // through it.
    bool touches = false;
  };
  // Nothing if the cell does not meet the facet. O(neighbours x corners of the cut).
  std::optional<Cut> Of(const Facet& facet);

  // Does the edge from the vertex to the neighbour in `slot` go through the facet?
  static bool GoesThrough(const SpaceStar& star, int slot, const Facet& facet);

 private:
  using Position =
      std::array<double, 2>;  // coordinates in the facet's plane, from the vertex's foot
  void Clip(double a, double b, double c);
  Position NearestToOrigin() const;
  double Area2() const;

  const SpaceStar* star_ = nullptr;
  std::vector<const SpaceStar::Neighbour*> neighbours_;  // in an order that depends on them alone
  std::vector<Position> polygon_, clipped_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CELL_CUT_H_
