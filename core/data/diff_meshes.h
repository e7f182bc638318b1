// The difference of two whole meshes. Thread-safe.
#ifndef DYNMESH_CORE_DATA_DIFF_MESHES_H_
#define DYNMESH_CORE_DATA_DIFF_MESHES_H_

#include "core/base/steps.h"
#include "dynmesh/mesh.h"

namespace dynmesh::data {

// What Apply would have to return to get from `from` to `to`: netted, no work counted, rows in
// no particular order. O(n lg n), n the size of both, O(n) if one is much smaller. Both must have
// the same dimension and agreeing columns; to.hash is taken as given. Taken by value: hand over
// what is not needed any more, its columns become the diff's.
// Where `steps` are stopped, so is this, at the latest when a column has been sorted: then what is
// returned is nothing.
MeshDiff DiffMeshes(Mesh from, Mesh to, Steps& steps);
MeshDiff DiffMeshes(Mesh from, Mesh to);

}  // namespace dynmesh::data

#endif  // DYNMESH_CORE_DATA_DIFF_MESHES_H_
