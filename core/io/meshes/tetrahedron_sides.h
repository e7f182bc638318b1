// The sides of a tetrahedron. Pure data.
#ifndef DYNMESH_CORE_IO_MESHES_TETRAHEDRON_SIDES_H_
#define DYNMESH_CORE_IO_MESHES_TETRAHEDRON_SIDES_H_

#include <cstddef>

namespace dynmesh::io {

// [k]: the corners of the side opposite to corner k, counter-clockwise as seen from outside.
inline constexpr std::size_t kTetrahedronSides[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_TETRAHEDRON_SIDES_H_
