// Input files of any kind as one set of features.
#ifndef DYNMESH_CLIENT_CLI_INPUT_H_
#define DYNMESH_CLIENT_CLI_INPUT_H_

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/elements/element_mesh.h"
#include "core/io/maps/mended_rings.h"
#include "core/io/space/face_rules.h"
#include "dynmesh/error.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct Input {
  std::vector<Feature> features;
  MeshOptions options;                // the box: the input's own, or its bounding box
  std::vector<std::string> warnings;  // content that was skipped
  // Seeds of holes and regions in a .poly or .smesh: in 2D AddSeedPolygons converts them to
  // polygons, in 3D Selection leaves out the holes.
  std::vector<io::SeedRow> holes;
  std::vector<io::SeedRow> regions;
  std::string seed_file;
  std::vector<FeatureId> hole_polygons;        // of `holes`, ascending
  std::vector<io::PolygonName> polygon_names;  // of a map's polygons
  io::MendedRings mended;                      // of a map, if asked for
  // Markers, names and attributes of points; names of a map's polygons, too. Not null.
  std::shared_ptr<const io::FeatureLabels> labels = std::make_shared<const io::FeatureLabels>();
  // "file:line" of a feature, empty if unknown.
  std::function<std::string(FeatureId)> where;
  // "file:line: rho" of the input's setting of a member of MeshOptions; empty if there is none.
  std::function<std::string(std::string_view)> where_option = [](std::string_view) {
    return std::string();
  };
};

// Flags for reading. INVALID_ARGUMENT if faces are to be merged and the input is 2D, or if polygons
// are asked for and it is no map.
struct InputFlags {
  bool merge_coplanar = false;  // 3D: merge coplanar faces to polygons
  double coplanar_tolerance = 0;
  bool polygons = false;                         // a map's polygons become polygon features
  bool refine = false;                           // the input is a mesh whose vertices become points
  io::FaceRules faces = io::FaceRules::kStrict;  // of surface files
  bool mend_rings = false;                       // of maps (map_files.h, MendedRings)
};
// --merge-coplanar, --coplanar-tolerance and --polygons.
void AddInputFlags(CLI::App& command, InputFlags& flags);

// Reads a file by its extension, in any case: .node, .poly; in 3D also .smesh, .off, .stl, .obj and
// .ply; .msh, .mesh and .vtu (lines, triangles and borders of a mesh; core/io/elements); .geojson,
// .topojson, .json (either of both). Any extension that is not a known kind of geometry is an edit
// script; its last revision counts. `options` has the dimension. Errors as `file:line: ...`.
inline constexpr char kSpaceInputKinds[] =
    ".node, .poly, .geojson, .topojson or an edit script; in 3D .node, .poly, .smesh, .off, "
    ".stl, .obj or .ply; of 2D and 3D meshes .msh, .mesh or .vtu";
absl::StatusOr<Input> LoadInput(const std::string& path, const InputFlags& flags = {});
// The same for the value of `flag`, the input of a mesh: INVALID_ARGUMENT if it has another
// dimension than that.
absl::StatusOr<Input> LoadInputOfMesh(const char* flag, const std::string& path, int dimension,
                                      const InputFlags& flags = {});

// The input that LoadInput makes of a mesh with this path.
absl::StatusOr<Input> InputOfElements(const io::ElementMesh& mesh, const std::string& path,
                                      InputFlags flags);

// Appends a polygon for each hole, then for each region: the face of the segments that contains its
// seed. Ids follow the greatest one, one per seed. As in Triangle, a seed outside of everything is
// ignored, and of several seeds in one face the first counts: the others are skipped, with a
// warning each. INVALID_ARGUMENT as `file:line: ...` for a seed on a segment. Segments must not
// cross; the mesh refuses them otherwise. A region's largest area becomes a sizing polygon, with
// the ids after those. Nothing is done in 3D.
absl::Status AddSeedPolygons(Input& input);

// What is said of features and a server's mesh has no place for: a warning, or empty.
std::string LabelsLeftOut(const Input& input, const std::string& path);

// `status` with the position of the first feature to blame before its message, and those of the
// others after it.
absl::Status Locate(const absl::Status& status, const std::function<std::string(FeatureId)>& where);
// The same for features that the caller has extracted from the status.
absl::Status LocateFeatures(const absl::Status& status, const std::vector<FeatureId>& features,
                            const std::function<std::string(FeatureId)>& where);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_INPUT_H_
