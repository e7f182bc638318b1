// What is done to all rows of a mesh and can be given up: Canonicalize and ComputeHash of
// dynmesh/mesh.h, asked between rows whether to go on. Where `steps` are stopped, so is the work:
// then the mesh is of no use, and the hash none. One thread.
#ifndef DYNMESH_CORE_DATA_WHOLE_MESH_H_
#define DYNMESH_CORE_DATA_WHOLE_MESH_H_

#include "core/base/steps.h"
#include "dynmesh/mesh.h"

namespace dynmesh::data {

void Canonicalize(Mesh& mesh, Steps& steps);

MeshHash ComputeHash(const Mesh& mesh, Steps& steps);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_WHOLE_MESH_H_
