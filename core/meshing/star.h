// The star of a vertex, in 2D or 3D.
#ifndef DYNMESH_CORE_MESHING_STAR_H_
#define DYNMESH_CORE_MESHING_STAR_H_

#include <cstddef>
#include <type_traits>

#include "core/meshing/planar_star.h"
#include "core/meshing/space_star.h"

namespace dynmesh::meshing {

template <int D>
using Star = std::conditional_t<D == 2, PlanarStar, SpaceStar>;

// The centre of corner i: a vertex of the Voronoi cell.
template <class S>
auto CentreOf(const S& star, int i) {
  auto centre = star.position();
  for (std::size_t k = 0; k < centre.c.size(); ++k) centre.c[k] += star.corner(i).w[k];
  return centre;
}

// True if the neighbour is a vertex.
template <int D>
bool IsInView(const typename Star<D>::Neighbour& u) {
  return Star<D>::IsUsed(u) && !Star<D>::IsGhost(u.id);
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_H_
