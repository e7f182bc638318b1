// The star of a vertex, in 2D or 3D.
#ifndef DYNMESH_CORE_MESHING_STAR_H_
#define DYNMESH_CORE_MESHING_STAR_H_

#include <type_traits>

#include "core/meshing/planar_star.h"
#include "core/meshing/space_star.h"

namespace dynmesh::meshing {

template <int D>
using Star = std::conditional_t<D == 2, PlanarStar, SpaceStar>;

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_H_
