// Surface files and maps as they come, mended where a mesh refuses them. In a library of its own,
// dynmesh::surfaces, which needs zlib and GMP.
//
//   const auto made = dynmesh::BuildSurface("part.stl");                 // check made.ok()
//   const auto inside = dynmesh::KeepInside(made->mesh);                 // dynmesh/files.h
//   const absl::Status status =
//       dynmesh::WriteMesh(*inside, made->surface.input.options, "part.msh");
//
// Files are prepared as by the command `dynmesh mesh`. What differs: the command leaves out
// cavities, shells whose faces look inward, which KeepInside keeps; and it makes no cures outside
// (BuildOptions::only_inside). Functions are thread-safe, and results are functions of the file and
// the choices. Preparation, some seconds of a large file, does not ask `interrupted`.
#ifndef DYNMESH_SURFACES_H_
#define DYNMESH_SURFACES_H_

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/feature.h"
#include "dynmesh/files.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

// All lengths are in the file's unit.
struct SurfaceChoices {
  // D: how far an edge or a face may move, in both directions. Default: 1e-4 of the diagonal of the
  // input's box. Given, files of all formats are prepared; else surfaces, maps, and 2D .poly and
  // .node.
  std::optional<double> within = {};
  // Of 3D: holes, loops of edges with one face, are filled up to this length.
  std::optional<double> fill_holes = {};
  // Of surfaces: mending has this tolerance or a larger one, even if a mesh accepts the surface.
  std::optional<double> mending_tolerance = {};
  bool polygons = true;      // rings of a map are polygons, not segments
  bool keep_facets = false;  // no faces are joined, and none are made fewer
};

// A loop of edges with one face.
struct SurfaceLoop {
  std::vector<FeatureId> points;      // each once, in order
  double length = 0;                  // of its edges together
  std::array<double, 3> middle = {};  // the mean of the points
};

// What was done to a file.
struct SurfaceReport {
  bool mended = false;    // it was mended
  bool thinned = false;   // faces finer than D needs became fewer; if neither, it is as it was read
  absl::Status found;     // what a mesh refuses of the file; of what is not mended, too
  absl::Status unfilled;  // what a mesh refuses of it with its holes filled
  double within = 0;      // D
  double tolerance = 0;   // of mending
  double farthest = 0;    // a bound of how far it moved, up to a factor of 2
  // The next one that may help where the mesh is too fine; nothing if D allows none.
  std::optional<double> larger_tolerance = {};
  // The least tolerance that it was mended with on request, or as its mesh was too fine without.
  std::optional<double> least_tolerance = {};
  std::size_t triangles_read = 0;                            // of the file, if it is thinned
  std::size_t triangles = 0;                                 // left of these
  std::size_t open_edges_read = 0;                           // of a 3D file: edges with one face
  std::size_t open_edges = 0;                                // left of these
  std::vector<SurfaceLoop> open_loops;                       // those left, by ascending length
  double seconds = 0;                                        // that it took
  std::vector<std::pair<std::string, std::size_t>> changes;  // "point merged", and how often
};

// A file as a mesh takes it.
struct PreparedSurface {
  FileInput input;       // options and features, as of ReadInput
  SurfaceReport report;  // what was done
};

// Reads and prepares the file at `path`: what crosses, overlaps, nearly touches or is there twice
// is mended, with the least tolerance that does, cracks are closed, and faces that are finer than D
// needs become fewer. If nothing within D helps, the features are as they were read, and
// `report.found` says why a mesh refuses them. INVALID_ARGUMENT as "file:line: what is wrong", for
// a length in `choices` that is not above 0 and finite, and if nothing is left; else as ReadInput.
// Expected O(n lg n) for each tolerance that is tried, some ten at most.
absl::StatusOr<PreparedSurface> PrepareSurface(const std::string& path,
                                               const SurfaceChoices& choices = {});

// A mesh of a file.
struct SurfaceMesh {
  Mesh mesh;                          // as of BuildMesh: it reaches far beyond the surface
  PreparedSurface surface;            // what it was made of
  std::vector<std::string> attempts;  // why there was a second one, and others
};

// Prepares the file at `path`, with `choices`, and makes its mesh. A surface that a mesh accepts
// may be too fine all the same: then larger tolerances are tried, up to D, and
// `surface.report.least_tolerance` is the one that helped. A surface that was mended is given up at
// 100,000 vertices, or 30 for each feature, as long as a larger tolerance may help. `build` is that
// of all attempts; its `valid` is ignored. Errors: those of PrepareSurface and BuildMesh;
// RESOURCE_EXHAUSTED if the mesh would have more than 2,000,000 vertices, or 500 for each feature.
// Eight meshes at most, mostly one.
absl::StatusOr<SurfaceMesh> BuildSurface(const std::string& path,
                                         const SurfaceChoices& choices = {},
                                         const BuildOptions& build = {});

}  // namespace dynmesh

#endif  // DYNMESH_SURFACES_H_
