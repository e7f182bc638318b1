// 2D meshes as ADCIRC's `fort.14` (`.14`, `.grd`), which SCHISM reads, too.
#ifndef DYNMESH_CORE_IO_SOLVERS_ADCIRC_WRITER_H_
#define DYNMESH_CORE_IO_SOLVERS_ADCIRC_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// Rows in the order of the mesh, from 1: vertices with a depth, the first attribute of the input's
// points, 0 without one; triangles; then the border, with the mesh on the left:
//   open boundaries  of what lies on features whose names begin with "open" or "ocean", in any
//   case;
//                    a chain a name, all around without the first vertex again
//   land             the rest: chains of type 0 on the outer border, of type 1, closed without the
//                    first vertex again, around islands; chains of islands with open parts have 0
// INVALID_ARGUMENT as NamePartsOf, where the border touches itself in a vertex, which ADCIRC does
// not take, and if there is such a name but nothing of the border on it; UNAVAILABLE, naming the
// path, if it cannot be written. REQUIRES: dimension 2.
absl::Status WriteAdcirc(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SOLVERS_ADCIRC_WRITER_H_
