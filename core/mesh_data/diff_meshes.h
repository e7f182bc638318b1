// The difference of two whole meshes. Thread-safe.
#ifndef DYNMESH_CORE_MESH_DATA_DIFF_MESHES_H_
#define DYNMESH_CORE_MESH_DATA_DIFF_MESHES_H_

#include "core/base/steps.h"
#include "dynmesh/mesh.h"

namespace dynmesh::mesh_data {

// The diff that Apply would return to get from `from` to `to`: netted, without work counters, rows
// in no particular order. REQUIRES: equal dimensions and consistent columns; to.hash is not
// checked. O(n lg n) for the size n of both, O(n) if one is much smaller. Takes the meshes by
// value: move in meshes no longer needed, their columns become the diff's. If `steps` stop, it
// stops at the latest after sorting one column, and the result is unspecified.
MeshDiff DiffMeshes(Mesh from, Mesh to, Steps& steps);
MeshDiff DiffMeshes(Mesh from, Mesh to);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_DIFF_MESHES_H_
