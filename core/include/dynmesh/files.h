// Files: features from input files, meshes to files, and the part of a mesh that its input
// encloses. In a library of its own, dynmesh::files, which needs zlib.
//
//   const auto input = dynmesh::ReadInput("plate.poly");                        // check input.ok()
//   const auto mesh = dynmesh::BuildMesh(input->features, input->options);      // and mesh.ok()
//   const auto inside = dynmesh::KeepInside(*mesh, input->holes);
//   const absl::Status status = dynmesh::WriteMesh(*inside, input->options, "plate.msh");
//
// Vertices and cells by number, with neighbours: dynmesh/slot_mesh.h. Functions are thread-safe.
#ifndef DYNMESH_FILES_H_
#define DYNMESH_FILES_H_

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh {

// The content of an input file.
struct FileInput {
  // Points 1, 2, ..., then segments, then polygons, in file order. Markers (0 left out) and names
  // of groups are their labels; a name that a label cannot have is kept, and BuildMesh refuses it.
  std::vector<Feature> features;
  // The file's options (an edit script), or the usual ones of its dimension and its bounding box.
  MeshOptions options;
  std::vector<std::array<double, 3>> holes;  // a place in each part that is to be left out
  std::map<FeatureId, std::string> places;   // "file:line" of each feature, for messages
};

// Reads the file at `path` by its extension: .node, .poly, .smesh (Triangle, TetGen), .off, .stl,
// .obj, .ply, .msh, .mesh, .vtu (curves, surfaces and borders of a mesh), .dynmesh (an edit script:
// the features after its last line). If `merge_coplanar`, faces of 3D input in one plane are
// joined. Errors: INVALID_ARGUMENT as "file:line: what is wrong", also for another extension;
// NOT_FOUND and the like if the file cannot be read. O(n lg n) for n lines.
absl::StatusOr<FileInput> ReadInput(const std::string& path, bool merge_coplanar = false);

// What closed outlines (in 3D surfaces) enclose of the whole `mesh`, without the parts that contain
// one of `holes` and without holes of polygons. Rows keep their order; the hash is that of the
// result. INVALID_ARGUMENT if nothing is enclosed. O(mesh) expected.
absl::StatusOr<Mesh> KeepInside(const Mesh& mesh,
                                std::span<const std::array<double, 3>> holes = {});

// Writes `mesh`, made with `options`, to `path` by its extension: .node (with .ele, .edge and, in
// 3D, .face beside it), .vtu, .msh (Gmsh 4.1) or .mesh (Medit). Names of labels become groups.
// Either the files are complete, or the former ones stay. INVALID_ARGUMENT for another extension,
// or a mesh with unknown ids; UNAVAILABLE if a file cannot be written. O(n lg n).
absl::Status WriteMesh(const Mesh& mesh, const MeshOptions& options, const std::string& path);

// Reads the mesh whose .node, .ele, .edge or .face is at `path`, as WriteMesh writes it: the same
// mesh, at revision 0. INVALID_ARGUMENT as "file:line: what is wrong"; NOT_FOUND without a .node or
// .ele; DATA_LOSS if the files record another hash than that of their rows. O(n lg n).
absl::StatusOr<Mesh> ReadMesh(const std::string& path);

}  // namespace dynmesh

#endif  // DYNMESH_FILES_H_
