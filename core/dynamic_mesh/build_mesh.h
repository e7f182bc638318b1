// Meshes from scratch, without a trace; by the mesher of dynamic meshes and by SVR.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_BUILD_MESH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_BUILD_MESH_H_

#include <span>

#include "absl/status/statusor.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh {

// BuildMesh (dynamic_mesh.h). REQUIRES: `options` are valid and of kind kDelaunay, and the engine
// supports them.
template <int D>
absl::StatusOr<Mesh> BuildDelaunay(std::span<const Feature> features, const MeshOptions& options,
                                   const BuildOptions& build);

// OK if SVR supports these options, else INVALID_ARGUMENT (BAD_OPTION).
absl::Status CheckSvrOptions(const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_BUILD_MESH_H_
