// Input files of any kind as one set of features.
#ifndef DYNMESH_CLIENT_CLI_INPUT_H_
#define DYNMESH_CLIENT_CLI_INPUT_H_

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/file_features.h"
#include "dynmesh/error.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct Input {
  std::vector<Feature> features;
  MeshOptions options;                // the box: the input's own, or its bounding box
  std::vector<std::string> warnings;  // what was read and left out
  // Places of a .poly that mark holes and regions: AddSeedPolygons makes polygons of them.
  std::vector<io::SeedRow> holes;
  std::vector<io::SeedRow> regions;
  std::string seed_file;
  std::vector<FeatureId> hole_polygons;        // those of holes, ascending
  std::vector<io::PolygonName> polygon_names;  // of a map's polygons
  // "file:line" of a feature, empty if unknown.
  std::function<std::string(FeatureId)> where;
  // "file:line: rho" of what says a member of MeshOptions; empty if nothing does.
  std::function<std::string(std::string_view)> where_option = [](std::string_view) {
    return std::string();
  };
};

// How input is read. INVALID_ARGUMENT if faces are to be joined and the input is of the plane.
struct InputFlags {
  bool merge_coplanar = false;  // of space: faces that lie in one plane become polygons
  double coplanar_tolerance = 0;
};
// --merge-coplanar and --coplanar-tolerance.
void AddInputFlags(CLI::App& command, InputFlags& flags);

// By extension, in whatever case: .node, .poly; of space also .smesh, .off, .stl and .obj;
// .geojson, .topojson, .json (whichever of the two it holds); any other that is no known kind of
// geometry is an edit script, whose last revision counts. The dimension stands in `options`; places
// of holes and regions of space are left out with a warning. Errors as `file:line: ...`.
inline constexpr char kInputKinds[] = ".node, .poly, .geojson, .topojson or an edit script";
inline constexpr char kSpaceInputKinds[] =
    ".node, .poly, .geojson, .topojson or an edit script; of space .node, .poly, .smesh, .off, "
    ".stl or .obj";
absl::StatusOr<Input> LoadInput(const std::string& path, const InputFlags& flags = {});
// Features of the plane are all that some commands can do with: UNIMPLEMENTED for others.
absl::Status ExpectPlanar(const Input& input, const std::string& path);
// A map whose polygons stay polygons (io/map_files.h). INVALID_ARGUMENT for any other file.
absl::StatusOr<Input> LoadMapWithPolygons(const std::string& path);

// Appends a polygon for each hole, then for each region: the face of the segments in which its
// seed lies, with the ids after the greatest one, one for each seed. As in Triangle, a seed
// outside everything marks nothing, and of several in one face the first one counts: those
// are left out, with a warning each. INVALID_ARGUMENT as `file:line: ...` for a seed on a
// segment. Segments must not cross; the mesh will tell if they do.
absl::Status AddSeedPolygons(Input& input);

// `status` with its message preceded by where the first feature to blame stands, and
// followed by where the others do.
absl::Status Locate(const absl::Status& status, const std::function<std::string(FeatureId)>& where);
// The same of features that somebody else read out of the status.
absl::Status LocateFeatures(const absl::Status& status, const std::vector<FeatureId>& features,
                            const std::function<std::string(FeatureId)>& where);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_INPUT_H_
