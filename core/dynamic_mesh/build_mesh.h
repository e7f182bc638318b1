// A Delaunay mesh from scratch: no trace; reads neighbourhoods from one growing triangulation.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_BUILD_MESH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_BUILD_MESH_H_

#include <span>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh {

// BuildMesh (dynamic_mesh.h). REQUIRES: `options` are valid and of kind kDelaunay.
template <int D>
absl::StatusOr<Mesh> BuildDelaunay(std::span<const Feature> features, const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_BUILD_MESH_H_
