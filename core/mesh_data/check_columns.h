// Consistency of the columns of a mesh or a diff. Pure functions, thread-safe.
#ifndef DYNMESH_CORE_MESH_DATA_CHECK_COLUMNS_H_
#define DYNMESH_CORE_MESH_DATA_CHECK_COLUMNS_H_

#include "absl/status/status.h"
#include "dynmesh/mesh.h"

namespace dynmesh::mesh_data {

// INVALID_ARGUMENT unless the columns agree in length and the region sets are valid, by ascending
// id. O(columns and region sets), independent of the number of rows.
absl::Status CheckColumns(const Mesh& mesh);
absl::Status CheckColumns(const MeshDiff& diff);

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_CHECK_COLUMNS_H_
