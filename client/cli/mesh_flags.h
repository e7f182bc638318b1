// The flags that say what a mesh is to be, shared by the commands that make one.
#ifndef DYNMESH_CLIENT_CLI_MESH_FLAGS_H_
#define DYNMESH_CLIENT_CLI_MESH_FLAGS_H_

#include <cstdint>
#include <optional>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/data/region_filter.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct MeshFlags {
  std::optional<double> rho;
  std::string criterion;
  std::string engine = "dynamic";
  std::string box;
  std::optional<double> max_edge;
  std::optional<std::uint64_t> max_vertices;
};

// --rho --criterion --engine --box --hmax --max-vertices
void AddMeshFlags(CLI::App& command, MeshFlags& flags);

// --box alone, and what it says if it was given.
void AddBoxFlag(CLI::App& command, std::string& text);
absl::Status ApplyBoxFlag(const std::string& text, MeshOptions& options);

// --region: of the mesh, only what lies in these polygons. Everything if it was not given.
void AddRegionFlag(CLI::App& command, std::string& text);
absl::StatusOr<data::RegionChoice> ParseRegionFlag(const std::string& text);

// Flags that were given override `options`.
absl::Status ApplyMeshFlags(const MeshFlags& flags, MeshOptions& options);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_MESH_FLAGS_H_
