// `dynmesh import` of 3D input: surfaces, cleaned on request, and made coarse where nearly flat.
#ifndef DYNMESH_CLIENT_CLI_IMPORT_SURFACE_H_
#define DYNMESH_CLIENT_CLI_IMPORT_SURFACE_H_

#include <cstdint>
#include <optional>
#include <string>

#include "client/cli/input.h"

namespace dynmesh::cli {

struct SurfaceImport {
  std::string input;
  std::string output;  // .poly, .smesh, .off or .dynmesh
  std::optional<double> tolerance;
  std::optional<double> feature_angle;  // in degrees: only edges sharper than this are kept
  std::optional<double> within;         // with feature_angle: how far the surface may move
  std::uint64_t max_steps = 0;          // of cleaning; 0: the default
  bool clean = false;
  bool all = false;  // count all that a mesh still refuses
  bool json = false;
};

// Writes the input's features, prints the summary. Returns the exit code.
int ImportSurface(const SurfaceImport& command, Input input);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_IMPORT_SURFACE_H_
