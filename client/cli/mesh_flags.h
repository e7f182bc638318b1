// The flags for mesh options, shared by the commands that make a mesh.
#ifndef DYNMESH_CLIENT_CLI_MESH_FLAGS_H_
#define DYNMESH_CLIENT_CLI_MESH_FLAGS_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/mesh_data/region_filter.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct MeshFlags {
  std::string kind;
  bool no_refine = false;
  std::optional<double> rho;
  std::string criterion;
  std::string engine = "dynamic";
  std::string box;
  std::optional<double> max_edge, min_dihedral;
  std::optional<double> min_angle, max_area, max_volume;  // other words for rho and max_edge
  std::optional<std::uint64_t> max_vertices;
};

// The value of a --box in 2D or 3D.
inline constexpr char kBoxOfEither[] = "X0,Y0[,Z0],X1,Y1[,Z1]";

// --kind --no-refine --rho --criterion --engine --box --hmax --min-dihedral --max-vertices, and
// --min-angle,
// --max-area and --max-volume for --rho and --hmax
void AddMeshFlags(CLI::App& command, MeshFlags& flags);

// Checks the rho for judging a mesh file, if given: 1 to 100.
absl::Status CheckRhoFlag(std::optional<double> rho);

// Checks the least dihedral angle for judging a mesh file, if given: 0 to 20 degrees, 3D only.
absl::Status CheckMinDihedralFlag(std::optional<double> min_dihedral);
absl::Status CheckMinDihedralFlag(std::optional<double> min_dihedral, const std::string& path,
                                  int dimension);

// --box alone, and its parsed value if given.
void AddBoxFlag(CLI::App& command, std::string& text);
absl::Status ApplyBoxFlag(const std::string& text, MeshOptions& options);

// --region: only the part of the mesh in these polygons. Default: everything.
void AddRegionFlag(CLI::App& command, std::string& text);
absl::StatusOr<mesh_data::RegionChoice> ParseRegionFlag(const std::string& text);

// "ID,ID,..." of --open.
absl::StatusOr<std::vector<FeatureId>> ParseOpenFlag(const std::string& text);

// --outside: only the part of the mesh outside these polygons. `holes` stands for the polygons of a
// file's holes; null if the input's kind has none.
void AddOutsideFlag(CLI::App& command, std::string& text);
absl::Status ApplyOutsideFlag(const std::string& text, const std::vector<FeatureId>* holes,
                              mesh_data::RegionChoice& choice);

// Warns of ids in the two that are not a region of `mesh`, the whole mesh.
void WarnOfUnknownRegions(const mesh_data::RegionChoice& choice, const Mesh& mesh);

// Renames the option in an error of the library to its name for the user: a flag, else the result
// of `where` (Input::where_option), "file:line: rho". Other errors are unchanged.
absl::Status NameOption(const absl::Status& status, const MeshFlags& flags,
                        const std::function<std::string(std::string_view)>& where);

// Given flags override `options`. Another kind than before begins with its defaults.
enum class MeshLife { kDynamic, kFromScratch };
absl::Status ApplyMeshFlags(const MeshFlags& flags, MeshOptions& options,
                            MeshLife life = MeshLife::kDynamic);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_MESH_FLAGS_H_
