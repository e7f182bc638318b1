// Meshes as Medit's ASCII `.mesh` (libMeshb), for Medit, MMG, FreeFEM and meshio.
#ifndef DYNMESH_CORE_IO_MEDIT_WRITER_H_
#define DYNMESH_CORE_IO_MEDIT_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/indexed_mesh.h"

namespace dynmesh::io {

// MeshVersionFormatted 2 (doubles), Dimension 2, rows in the canonical order of IndexedMesh,
// numbered from 1:
//   Vertices   x y reference of the owner, 0 if free; coordinates read back bit for bit
//   Edges      the subsegments, with the reference of the owner
//   Triangles  counter-clockwise, reference 1; in polygons 1 + the number of the region
//              (region_numbers.h)
// The other references are those of references.h; comments after the dimension list which is
// which.
// INVALID_ARGUMENT if there are too many rows, UNAVAILABLE, naming the path, on trouble.
absl::Status WriteMedit(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MEDIT_WRITER_H_
