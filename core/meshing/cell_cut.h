// What a vertex's Voronoi cell has of a facet.
//
// The cell of a vertex that is not on the facet has nothing of it where the facet's vertices are
// dense enough: every place of the facet is then nearest to one of them, and the triangles that
// they span there have empty balls about centres in the facet: they are in the triangulation.
// Subsegments have empty balls already, so that no cell of others reaches the facet's border:
// what there is of the facet's plane is inside the facet as a whole, or outside.
//
// A function of the set of neighbours of the star and of the facet, to the bit. One object is
// used for many stars: no allocation once warm. Thread-compatible.
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
  // From now on of that star, which must not change meanwhile.
  void Begin(const SpaceStar& star);

  struct Cut {
    geometry::Point3 nearest = {};  // to the vertex, of what the cell has of the facet
    double distance2 = 0;           // from there to the vertex
    // The cell only touches the facet, as far as rounding can tell: only a neighbour on the
    // facet's far side, joined through it, would keep the facet out of the triangulation.
    bool touches = false;
  };
  // Nothing if the cell has none of the facet. O(neighbours x corners of the cut).
  std::optional<Cut> Of(const Facet& facet);

  // Does the edge from the vertex to the neighbour in `slot` go through the facet?
  static bool GoesThrough(const SpaceStar& star, int slot, const Facet& facet);

 private:
  using Place = std::array<double, 2>;  // in the facet's plane, from the vertex's foot
  void Clip(double a, double b, double c);
  Place NearestToOrigin() const;
  double Area2() const;

  const SpaceStar* star_ = nullptr;
  std::vector<const SpaceStar::Neighbour*> neighbours_;  // in an order that depends on them alone
  std::vector<Place> polygon_, clipped_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CELL_CUT_H_
