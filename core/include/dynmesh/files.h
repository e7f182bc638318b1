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
  // Points 1, 2, ..., then segments, then polygons, in file order; joined faces are a polygon with
  // the least of their ids. Markers (0 left out) and names of groups are their labels; a name that
  // a label cannot have is kept, and BuildMesh refuses it.
  std::vector<Feature> features;
  // The file's options (an edit script), or the usual ones of its dimension and its bounding box.
  MeshOptions options;
  std::vector<std::array<double, 3>> holes;  // a place in each part that is to be left out
  std::map<FeatureId, std::string> places;   // "file:line" of each feature, for messages
  std::vector<std::string> warnings;         // content that was left out
};

// What is made of a file's content.
struct InputChoices {
  bool merge_coplanar = false;  // 3D: faces in one plane that have one marker are joined
  bool polygons = false;        // rings of a map are polygons, not segments
  // The file is a mesh to be refined (.node with its .ele, .msh, .mesh, .vtu): all its vertices are
  // points, and largest areas or volumes beside it are sizes. In 3D faces are joined, too.
  bool refine = false;
  // Of .off, .stl, .obj and .ply: faces in one plane, within the rounding of the file's numbers,
  // stay as they are. Otherwise those of one marker and name become one polygon, whose corners move
  // onto the plane, by 4 roundings at most; a warning has the counts.
  bool keep_facets = false;
};

// Reads the file at `path` by its extension: .node, .poly, .smesh (Triangle, TetGen), .off, .stl,
// .obj, .ply, .msh, .mesh, .vtu (curves, surfaces and borders of a mesh), .geojson, .topojson and
// .json (maps), .dynmesh (an edit script: the features after its last line). `choices` are as
// above. Errors: INVALID_ARGUMENT as "file:line: what is wrong", also for another extension;
// UNIMPLEMENTED for those of other programs' geometry; NOT_FOUND and the like if the file cannot be
// read. O(n lg n) for n lines.
absl::StatusOr<FileInput> ReadInput(const std::string& path, const InputChoices& choices = {});
// The same with `merge_coplanar` as the only choice, for the file at `path`.
absl::StatusOr<FileInput> ReadInput(const std::string& path, bool merge_coplanar);

// Reads target lengths for `input` from the file at `path`, by its extension: .asc (a raster of
// ESRI, 2D), .npy (an array of numpy, which covers the box), .pos (a view of Gmsh), .mtr (TetGen's,
// of the input's points, or with .node and .ele of its own). The result are sizing features in the
// box of `input.options`, with ids after the greatest one of `input.features`. Errors as above.
// O(file + features).
absl::StatusOr<std::vector<Feature>> ReadSizes(const std::string& path, const FileInput& input);

// What closed outlines (in 3D surfaces) enclose of the whole `mesh`, without the parts that contain
// one of `holes` and without holes of polygons. Rows keep their order; the hash is that of the
// result. INVALID_ARGUMENT if nothing is enclosed. O(mesh) expected.
absl::StatusOr<Mesh> KeepInside(const Mesh& mesh,
                                std::span<const std::array<double, 3>> holes = {});

// How a mesh is written.
struct OutputChoices {
  int order = 1;             // of elements; 2: with a node in the middle of each edge
  bool from_zero = false;    // a .node and the files beside it are numbered from 0, not 1
  bool neighbours = false;   // with a .node, the neighbours of simplices as .neigh
  bool voronoi = false;      // with a .node, the Voronoi diagram as .v.node and .v.edge
  double msh_version = 4.1;  // of a .msh: 4.1 or 2.2
  bool binary = false;       // a .msh has its numbers as bytes, which are read faster
  // Markers of labels are those of rows, and of regions the ones of their polygons. Otherwise a
  // file has ids of features and numbers of regions; a .vtu has both in any case.
  bool input_markers = false;
  bool part = false;  // the mesh is a part of a mesh (KeepInside, MeshPart): a .node says so
};

// Writes `mesh`, made with `options`, to `path` by its extension: .node (with .ele, .edge and, in
// 3D, .face beside it; .poly, .smesh or .neigh with that file, too), .vtu, .msh (Gmsh), .mesh
// (Medit), .inp (Abaqus), .su2, in 2D .2dm (SMS), .14 or .grd (ADCIRC), or .svg (a picture: angles
// of triangles, of a 3D mesh those in a cut); a quadtree to .csv, .vtu or .svg. `choices` are as
// above. Names of labels become groups. Either the files are complete, or the former ones stay.
// INVALID_ARGUMENT for another extension, a mesh with unknown ids, or an order that the format does
// not have; UNAVAILABLE if a file cannot be written. O(n lg n).
absl::Status WriteMesh(const Mesh& mesh, const MeshOptions& options, const std::string& path,
                       const OutputChoices& choices = {});

// Reads the mesh at `path`, by its extension. Of a .node, .ele, .edge or .face, and of the leaves
// of a quadtree (.csv), as WriteMesh writes them, it is the same mesh, at revision 0. Of a .vtu,
// .msh or .mesh, of any program, owners are markers, or 1 on the border. INVALID_ARGUMENT as
// "file:line: what is wrong", also for another extension; NOT_FOUND without the file, or a .node
// without its .ele; DATA_LOSS if files record another hash than that of their rows. O(n lg n).
absl::StatusOr<Mesh> ReadMesh(const std::string& path);

}  // namespace dynmesh

#endif  // DYNMESH_FILES_H_
