// Meshes as `.su2`, for SU2.
#ifndef DYNMESH_CORE_IO_SOLVERS_SU2_WRITER_H_
#define DYNMESH_CORE_IO_SOLVERS_SU2_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// NDIME, NELEM, NPOIN and NMARK: rows in the order of the mesh, from 0; a marker a set of
// named_facets.h, its border facets alone, since the format has no others: each facet of the border
// is in one marker. Names are words (WordsOf). Facets are directed as CornersOf has them.
// UNAVAILABLE, naming the path, if it cannot be written; INVALID_ARGUMENT as NamePartsOf.
absl::Status WriteSu2(const IndexedMesh& mesh, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SOLVERS_SU2_WRITER_H_
