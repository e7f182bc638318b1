// The flags that say what a mesh is to be, shared by the commands that make one.
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
#include "core/data/region_filter.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct MeshFlags {
  std::optional<double> rho;
  std::string criterion;
  std::string engine = "dynamic";
  std::string box;
  std::optional<double> max_edge, min_dihedral;
  std::optional<std::uint64_t> max_vertices;
};

// The value of a --box that may be one of space.
inline constexpr char kBoxOfEither[] = "X0,Y0[,Z0],X1,Y1[,Z1]";

// --rho --criterion --engine --box --hmax --min-dihedral --max-vertices
void AddMeshFlags(CLI::App& command, MeshFlags& flags);

// The rho that a mesh file is judged by, if it is given: 1 to 100.
absl::Status CheckRhoFlag(std::optional<double> rho);

// The least dihedral angle that a mesh file is judged by, if it is given: 0 to 20 degrees, and only
// of a mesh of space.
absl::Status CheckMinDihedralFlag(std::optional<double> min_dihedral);
absl::Status CheckMinDihedralFlag(std::optional<double> min_dihedral, const std::string& path,
                                  int dimension);

// --box alone, and what it says if it was given.
void AddBoxFlag(CLI::App& command, std::string& text);
absl::Status ApplyBoxFlag(const std::string& text, MeshOptions& options);

// --region: of the mesh, only what lies in these polygons. Everything if it was not given.
void AddRegionFlag(CLI::App& command, std::string& text);
absl::StatusOr<data::RegionChoice> ParseRegionFlag(const std::string& text);

// --outside: of the mesh, nothing that lies in one of these polygons. `holes` stands for
// those of a file's holes; null if the input is of a kind that has none.
void AddOutsideFlag(CLI::App& command, std::string& text);
absl::Status ApplyOutsideFlag(const std::string& text, const std::vector<FeatureId>* holes,
                              data::RegionChoice& choice);

// Tells which ids of the two are those of no region of `mesh`, all of it.
void WarnOfUnknownRegions(const data::RegionChoice& choice, const Mesh& mesh);

// An error of an option, with the word by which the user gave it in place of the library's: a
// flag, else what `where` knows (Input::where_option), "file:line: rho". Others as they are.
absl::Status NameOption(const absl::Status& status, const MeshFlags& flags,
                        const std::function<std::string(std::string_view)>& where);

// Flags that were given override `options`.
absl::Status ApplyMeshFlags(const MeshFlags& flags, MeshOptions& options);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_MESH_FLAGS_H_
