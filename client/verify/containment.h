// Does a simplex contain a place? Exact: CGAL's kernel decides.
#ifndef DYNMESH_CLIENT_VERIFY_CONTAINMENT_H_
#define DYNMESH_CLIENT_VERIFY_CONTAINMENT_H_

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <array>

#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::cli {

// Inside or on the border of the triangle, which is counter-clockwise; z does not count.
inline bool Contains(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t,
                     const std::array<double, 3>& place) {
  using Corner = CGAL::Exact_predicates_inexact_constructions_kernel::Point_2;
  const Corner p(place[0], place[1]);
  std::array<Corner, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = {mesh.vertices[t[k]].x, mesh.vertices[t[k]].y};
  return CGAL::orientation(corners[0], corners[1], p) != CGAL::NEGATIVE &&
         CGAL::orientation(corners[1], corners[2], p) != CGAL::NEGATIVE &&
         CGAL::orientation(corners[2], corners[0], p) != CGAL::NEGATIVE;
}

// The same of a positive tetrahedron.
inline bool Contains(const io::IndexedMesh& mesh, const io::IndexedMesh::Tetrahedron& t,
                     const std::array<double, 3>& place) {
  using Corner = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  const Corner p(place[0], place[1], place[2]);
  std::array<Corner, 4> c;
  for (std::size_t k = 0; k < 4; ++k) {
    const io::IndexedMesh::Vertex& v = mesh.vertices[t[k]];
    c[k] = {v.x, v.y, v.z};
  }
  return CGAL::orientation(p, c[1], c[2], c[3]) != CGAL::NEGATIVE &&
         CGAL::orientation(c[0], p, c[2], c[3]) != CGAL::NEGATIVE &&
         CGAL::orientation(c[0], c[1], p, c[3]) != CGAL::NEGATIVE &&
         CGAL::orientation(c[0], c[1], c[2], p) != CGAL::NEGATIVE;
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_CONTAINMENT_H_
