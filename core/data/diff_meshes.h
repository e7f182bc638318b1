// The difference of two whole meshes. Pure function, thread-safe.
#ifndef DYNMESH_CORE_DATA_DIFF_MESHES_H_
#define DYNMESH_CORE_DATA_DIFF_MESHES_H_

#include "dynmesh/mesh.h"

namespace dynmesh::data {

// What Apply would have to return to get from `from` to `to`: canonical, netted, no
// work counted. O(size of both). Both must have the same dimension and agreeing
// columns; to.hash is taken as given.
MeshDiff DiffMeshes(const Mesh& from, const Mesh& to);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_DIFF_MESHES_H_
