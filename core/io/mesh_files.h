// Meshes as files, rows numbered from 1, in the canonical order of IndexedMesh. In the plane
// Triangle's, in space TetGen's: NAME.node, NAME.ele, NAME.edge and, in space, NAME.face side by
// side.
//   .node  number x y [z] marker     feature id on input points, -1 on the domain
//                                    box, else 0
//   .ele   number corner corner corner [corner] [region]    positively oriented; if there are
//                                    polygons, the number of the region (region_numbers.h)
//   .edge  number end end marker     all edges; feature id on subsegments, -1 on the
//                                    box's sides, else 0
//   .face  number corner corner corner marker    feature id on subfacets, -1 on the other
//                                    triangles of the domain's border; no others are listed
// Coordinates read back bit for bit. What markers cannot tell follows the rows, as
// comments that others skip: the mesh hash, which vertices of the box were put
// on its sides (containing dimension 1, not 0) or, in space, its faces (2) by refinement, and in
// the .ele the polygons of each region. Attributes of simplices without such comments are skipped.
#ifndef DYNMESH_CORE_IO_MESH_FILES_H_
#define DYNMESH_CORE_IO_MESH_FILES_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/indexed_mesh.h"
#include "core/io/text_reader.h"

namespace dynmesh::io {

// `path` is one of them or their common stem. All are written, or the ones before stay;
// UNAVAILABLE, naming the file, if one cannot be.
absl::Status WriteMeshFiles(const IndexedMesh& mesh, const std::string& path);

struct MeshFiles {
  IndexedMesh mesh;       // rows in file order, orientation as in the file
  bool has_edges = true;  // false: there is no .edge file
  bool has_faces = true;  // in space; false: there is no .face file
  std::optional<MeshHash> recorded_hash;
};

// Reads what it is told, valid mesh or not (that is for `verify`): only form, counts
// and vertex numbers are checked, INVALID_ARGUMENT as `file:line: ...`. A missing
// .edge or .face file is none; a missing .node or .ele is NOT_FOUND. The header of the .node
// tells the dimension; in the plane a .face is not looked at.
absl::StatusOr<MeshFiles> ReadMeshFiles(const std::string& path);
// The same of text that is there already.
absl::StatusOr<MeshFiles> ParseMeshFiles(TextReader nodes, TextReader triangles,
                                         std::optional<TextReader> edges,
                                         std::optional<TextReader> faces = std::nullopt);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESH_FILES_H_
