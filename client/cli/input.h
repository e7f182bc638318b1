// Input files of any kind as one set of features.
#ifndef DYNMESH_CLIENT_CLI_INPUT_H_
#define DYNMESH_CLIENT_CLI_INPUT_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/preparation/prepare.h"
#include "core/io/common/locate.h"
#include "core/io/formats/formats.h"
#include "core/io/formats/geometry.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

using io::Locate;
using io::LocateFeatures;

// Seeds of holes and regions: in 2D AddSeedPolygons converts them to polygons, in 3D Selection
// leaves out the holes.
struct Input : io::Geometry {
  std::vector<FeatureId> hole_polygons;            // of `holes`, ascending
  std::optional<preparation::Report> preparation;  // of one that was prepared
  // Of a surface file: its points and faces as they come, oriented as there. May be null.
  std::function<std::vector<Feature>()> read_faces;
};

// Flags for reading. INVALID_ARGUMENT if faces are to be merged and the input is 2D, or if polygons
// are asked for and it is no map.
struct InputFlags : io::GeometryOptions {
  bool merge_coplanar = false;  // 3D: merge coplanar faces to polygons
  double coplanar_tolerance = 0;
  // Prepare files that are prepared by default (preparation/prepare.h), or, with `within` or
  // `fill_holes`, any.
  bool prepare = false;
  std::optional<double> within;
  std::optional<double> fill_holes;       // the longest (preparation/open_loops.h)
  std::optional<double> least_tolerance;  // of mending
  // A map's polygons are polygons even without `polygons`.
  bool is_map_of_polygons = false;
};
// --keep-facets, --merge-coplanar, --coplanar-tolerance and --polygons.
void AddInputFlags(CLI::App& command, InputFlags& flags);
// Of commands that make a mesh of a file, or compare them: --segments, and polygons without it.
void AddMapFlags(CLI::App& command, InputFlags& flags);
// Of these and `load`: --exact, --within, --fill-holes and --mending-tolerance.
void AddPreparationFlags(CLI::App& command, InputFlags& flags);

// Reads a file by its extension (core/io/formats). Any extension that is not a known kind of
// geometry is an edit script; its last revision counts. `options` has the dimension. Errors as
// `file:line: ...`.
absl::StatusOr<Input> LoadInput(const std::string& path, const InputFlags& flags = {});
// The same for the value of `flag`, the input of a mesh: INVALID_ARGUMENT if it has another
// dimension than that.
absl::StatusOr<Input> LoadInputOfMesh(const char* flag, const std::string& path, int dimension,
                                      const InputFlags& flags = {});

// The input that LoadInput makes of a mesh with this path.
absl::StatusOr<Input> InputOfElements(const io::ElementMesh& mesh, const std::string& path,
                                      const InputFlags& flags);

// Appends a polygon for each hole, then for each region: the face of the segments that contains its
// seed. Ids follow the greatest one, one per seed. As in Triangle, a seed outside of everything is
// ignored, and of several seeds in one face the first counts: the others are skipped, with a
// warning each. INVALID_ARGUMENT as `file:line: ...` for a seed on a segment. Segments must not
// cross; the mesh refuses them otherwise. A region's largest area becomes a sizing polygon, with
// the ids after those. Nothing is done in 3D.
absl::Status AddSeedPolygons(Input& input);

// What is said of features and a server's mesh has no place for: a warning, or empty.
std::string LabelsLeftOut(const Input& input, const std::string& path);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_INPUT_H_
