// Cancellable work on all rows of a mesh: Canonicalize and ComputeHash of dynmesh/mesh.h, polling
// `steps` between rows. If `steps` stop, the mesh or hash is unspecified. One thread.
#ifndef DYNMESH_CORE_MESH_DATA_WHOLE_MESH_H_
#define DYNMESH_CORE_MESH_DATA_WHOLE_MESH_H_

#include "core/base/steps.h"
#include "dynmesh/mesh.h"

namespace dynmesh::mesh_data {

void Canonicalize(Mesh& mesh, Steps& steps);

MeshHash ComputeHash(const Mesh& mesh, Steps& steps);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_WHOLE_MESH_H_
