// The link of a vertex, read off a triangulation.
#ifndef DYNMESH_CORE_MESHING_LINK_H_
#define DYNMESH_CORE_MESHING_LINK_H_

#include <vector>

#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/delaunay/delaunay_triangulation.h"
#include "core/meshing/elements.h"

namespace dynmesh::meshing {

// The simplices around a vertex, as a triangulation has them.
template <int D>
struct LinkOf;
template <>
struct LinkOf<2> {
  std::vector<delaunay::DelaunayTriangulation::Corner> corners;  // counter-clockwise

  void Read(const delaunay::DelaunayTriangulation& triangulation, VertexIndex v) {
    triangulation.CornersAround(v, &corners);
  }
};
template <>
struct LinkOf<3> : delaunay::DelaunayTetrahedralization::VertexLink {
  void Read(const delaunay::DelaunayTetrahedralization& triangulation, VertexIndex v) {
    triangulation.LinkOf(v, this);
  }
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_LINK_H_
