// Meshes as Abaqus's `.inp`, for Abaqus and CalculiX.
#ifndef DYNMESH_CORE_IO_SOLVERS_ABAQUS_WRITER_H_
#define DYNMESH_CORE_IO_SOLVERS_ABAQUS_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// Rows in the order of the mesh, from 1:
//   *NODE     x, y, z; of at most 20 characters, as programs read no more: what is longer is
//   rounded
//             to the digits that fit, 13 at least
//   *ELEMENT  a block a region, in the set of its name: CPS3 (plane stress) and C3D4, of order 2
//             CPS6 and C3D10
//   *NSET     for each set of named_facets.h, the vertices on it, ascending; of order 2 with
//             midpoints
//   *SURFACE  the same with S_ before the name: elements and their sides, as loads take them
// Names are words (WordsOf) of at most 72 characters; comments have those that were changed.
// UNAVAILABLE, naming the path, if it cannot be written; INVALID_ARGUMENT as NamePartsOf.
absl::Status WriteAbaqus(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SOLVERS_ABAQUS_WRITER_H_
