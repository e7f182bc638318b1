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
#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/facet_field.h"
#include "core/meshing/space_star.h"

namespace dynmesh::meshing {

class CellCut {
 public:
  using Neighbour = SpaceStar::Neighbour;

  // Selects the star. It must not change while it is used.
  void Begin(const SpaceStar& star);
  // The same by position, neighbours in use, and an upper bound of the distance of the cell's
  // corners, as far as facets matter.
  void Begin(const geometry::Point3& position, double reach, std::span<const Neighbour> neighbours);

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
  // The same without a look at MayMeet: for tests.
  std::optional<Cut> NaiveOf(const Facet& facet);
  // False if the facet is certainly outside of the cell: then Of finds nothing. Most facets at hand
  // are, and it takes a few neighbours to see that, as a facet is small beside a cell's plane.
  bool MayMeet(const Facet& facet);
  // The corner of the last intersection that is farthest from the vertex, among those in the
  // facet's inside; nothing if there is none.
  std::optional<geometry::Point3> Farthest(const Facet& facet) const;

  // Does the edge from the vertex at `position` to the neighbour go through the facet?
  static bool GoesThrough(const geometry::Point3& position, const Neighbour& neighbour,
                          const Facet& facet);

 private:
  using Position =
      std::array<double, 2>;  // coordinates in the facet's plane, from the vertex's foot
  void BeginSorted();
  void Clip(double a, double b, double c);
  // On the facet's plane.
  geometry::Point3 At(const Position& position, const Facet& facet) const;
  Position NearestToOrigin() const;
  double Area2() const;

  geometry::Point3 p_ = {};
  double reach_ = 0;
  std::vector<const Neighbour*> neighbours_;  // in an order that depends on them alone
  std::vector<double> lengths_;               // how far they are
  std::vector<Position> polygon_, clipped_;
  std::vector<double> over_;  // of Clip
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CELL_CUT_H_
