// Meshes as Triangle's files: NAME.node, NAME.ele and NAME.edge side by side, rows
// numbered from 1, in the canonical order of IndexedMesh.
//   .node  number x y marker         feature id on input points, -1 on the domain
//                                    box, else 0
//   .ele   number corner corner corner [region]    counter-clockwise; if there are
//                                    polygons, the number of the region (region_numbers.h)
//   .edge  number end end marker     all edges; feature id on subsegments, -1 on the
//                                    box's sides, else 0
// Coordinates read back bit for bit. What markers cannot tell follows the rows, as
// comments that others skip: the mesh hash, which vertices of the box were put
// on its sides by refinement (containing dimension 1, not 0), and in the .ele the polygons
// of each region. Attributes of triangles without such comments are skipped.
#ifndef DYNMESH_CORE_IO_MESH_FILES_H_
#define DYNMESH_CORE_IO_MESH_FILES_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/indexed_mesh.h"
#include "core/io/text_reader.h"

namespace dynmesh::io {

// `path` is one of the three or their common stem. All three are written, or the
// ones before stay; UNAVAILABLE, naming the file, if one cannot be.
absl::Status WriteMeshFiles(const IndexedMesh& mesh, const std::string& path);

struct MeshFiles {
  IndexedMesh mesh;       // rows in file order, orientation as in the file
  bool has_edges = true;  // false: there is no .edge file
  std::optional<MeshHash> recorded_hash;
};

// Reads what it is told, valid mesh or not (that is for `verify`): only form, counts
// and vertex numbers are checked, INVALID_ARGUMENT as `file:line: ...`. A missing
// .edge file is none; a missing .node or .ele is NOT_FOUND.
absl::StatusOr<MeshFiles> ReadMeshFiles(const std::string& path);
// The same of text that is there already.
absl::StatusOr<MeshFiles> ParseMeshFiles(TextReader nodes, TextReader triangles,
                                         std::optional<TextReader> edges);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESH_FILES_H_
