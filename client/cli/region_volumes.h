// Largest volumes of regions in 3D input, as TetGen's -a.
#ifndef DYNMESH_CLIENT_CLI_REGION_VOLUMES_H_
#define DYNMESH_CLIENT_CLI_REGION_VOLUMES_H_

#include <functional>

#include "absl/status/statusor.h"
#include "client/cli/input.h"
#include "dynmesh/mesh.h"

namespace dynmesh::cli {

// `build` makes a mesh of `input`. As long as a tetrahedron in a region with a largest volume is
// larger, its inscribed ball becomes a sizing feature of the input, and the mesh is made anew: a
// few rounds, as each ball refines around itself. In 2D, or without such regions, it is made once.
// RESOURCE_EXHAUSTED if kMostVolumeRounds are not enough; INVALID_ARGUMENT for a seed on a facet.
inline constexpr int kMostVolumeRounds = 30;
absl::StatusOr<Mesh> BuildWithinVolumes(const std::function<absl::StatusOr<Mesh>()>& build,
                                        Input& input);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_REGION_VOLUMES_H_
