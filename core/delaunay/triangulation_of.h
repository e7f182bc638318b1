// The Delaunay triangulation of each dimension.
#ifndef DYNMESH_CORE_DELAUNAY_TRIANGULATION_OF_H_
#define DYNMESH_CORE_DELAUNAY_TRIANGULATION_OF_H_

#include <type_traits>

#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/delaunay/delaunay_triangulation.h"

namespace dynmesh::delaunay {

template <int D>
using TriangulationOf =
    std::conditional_t<D == 2, DelaunayTriangulation, DelaunayTetrahedralization>;

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_TRIANGULATION_OF_H_
