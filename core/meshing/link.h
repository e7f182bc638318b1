// The link of a vertex, read off a triangulation.
#ifndef DYNMESH_CORE_MESHING_LINK_H_
#define DYNMESH_CORE_MESHING_LINK_H_

#include <vector>

#include "core/mesh/delaunay_tetrahedralization.h"
#include "core/mesh/delaunay_triangulation.h"
#include "core/meshing/elements.h"

namespace dynmesh::meshing {

// The simplices around a vertex, as a triangulation has them.
template <int D>
struct LinkOf;
template <>
struct LinkOf<2> {
  std::vector<mesh::DelaunayTriangulation::Corner> corners;  // counter-clockwise

  void Read(const mesh::DelaunayTriangulation& triangulation, VertexIndex v) {
    triangulation.CornersAround(v, &corners);
  }
};
template <>
struct LinkOf<3> : mesh::DelaunayTetrahedralization::VertexLink {
  void Read(const mesh::DelaunayTetrahedralization& triangulation, VertexIndex v) {
    triangulation.LinkOf(v, this);
  }
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_LINK_H_
