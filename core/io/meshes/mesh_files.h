// Meshes as files, rows numbered from 1, in the canonical order of IndexedMesh. 2D: Triangle's
// files; 3D: TetGen's. NAME.node, NAME.ele, NAME.edge and, in 3D, NAME.face side by side.
//   .node  number x y [z] [attributes] marker    feature id on input points, -1 on the domain
//                                    box, else 0; if labels say so, the id of the segment or
//                                    polygon on Steiner points; the attributes of labels
//   .ele   number corner corner corner [corner] [region]    positively oriented; with
//                                    polygons, the number of the region (region_numbers.h)
//   .edge  number end end marker     all edges; feature id on subsegments, -1 on the
//                                    box's sides, else 0
//   .face  number corner corner corner marker    feature id on subfacets, -1 on the other
//                                    triangles of the domain's border; no others are listed
// Coordinates read back bit for bit. Comments after the rows, which other readers skip, hold what
// markers cannot: the mesh hash; the box's vertices that refinement put on its sides (containing
// dimension 1, not 0) or, in 3D, its faces (2); and in the .ele the polygons of each region.
// Without these comments, attributes of simplices are ignored. Names of features are comments, too.
//
// If the mesh's labels replace ids, markers are the input's and the attribute of a simplex is that
// of its region; where regions have none, the marker of region_labels.h, if any has one. A comment
// says so; such files are read as if they had no markers.
#ifndef DYNMESH_CORE_IO_MESHES_MESH_FILES_H_
#define DYNMESH_CORE_IO_MESHES_MESH_FILES_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/text_reader.h"
#include "core/io/common/triangle_sections.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

struct MeshFileOptions {
  bool from_zero = false;  // vertices and all rows are numbered from 0
  bool neighbours =
      false;             // with .neigh: the simplices across the sides opposite to corners, or -1
  bool voronoi = false;  // with .v.node and .v.edge, the dual of the mesh
  bool is_part = false;  // comments say so: it does not fill its box
  bool is_triangulation = false;     // comments say so: of kind triangulation, without bounds
  double rho = 0, min_dihedral = 0;  // comments have the bounds that the mesh was made with; 0: no
  std::vector<SeedRow> holes;        // of a .poly or .smesh
  std::optional<MeshHash> hash;      // of the mesh if it is known; otherwise it is computed
  int threads = 1;                   // that make text at once, at most; no byte depends on it
  std::uint64_t base() const { return from_zero ? 0 : 1; }
};

// `path` is one of the files or their common stem. With .poly or .smesh as extension there is also
// that file: without vertices, and with subsegments or subfacets as segments or facets. In 2D it is
// for `triangle -rp`; in 3D for `tetgen -p`, and only the .node is beside it. Either all are
// written, or the former ones stay; UNAVAILABLE, naming the file, if one cannot be written. Of a
// mesh with midpoints (order 2), .ele has them behind the corners, in the order of Triangle or
// TetGen, and no hash is recorded.
absl::Status WriteMeshFiles(const IndexedMesh& mesh, const std::string& path,
                            const MeshFileOptions& options = {});

// The common stem of the files that `path` is one of.
std::string StemOfMeshFiles(const std::string& path);

struct MeshFiles {
  IndexedMesh mesh;       // rows and orientation as in the file
  bool has_edges = true;  // false: there is no .edge file
  bool has_faces = true;  // 3D; false: there is no .face file
  std::optional<MeshHash> recorded_hash;
  std::optional<double> rho, min_dihedral;  // recorded bounds
  bool is_part = false;                     // it is recorded that the mesh does not fill its box
  bool is_triangulation = false;            // it is recorded that it is of kind triangulation
  bool has_input_markers = false;           // markers are the input's: no owner is known
  std::map<FeatureId, std::string> names;   // of features
};

// Reads any content, valid mesh or not (`verify` checks that). Checks only form, counts and vertex
// numbers: INVALID_ARGUMENT as `file:line: ...`. A missing .edge or .face file is allowed; a
// missing .node or .ele is NOT_FOUND. The header of the .node has the dimension; in 2D a .face is
// ignored.
absl::StatusOr<MeshFiles> ReadMeshFiles(const std::string& path);
// The same from texts in memory.
absl::StatusOr<MeshFiles> ParseMeshFiles(TextReader nodes, TextReader triangles,
                                         std::optional<TextReader> edges,
                                         std::optional<TextReader> faces = std::nullopt);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MESHES_MESH_FILES_H_
