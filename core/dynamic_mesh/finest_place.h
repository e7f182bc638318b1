// Where a mesh that is too large is finest: for the error that says so.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_FINEST_PLACE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_FINEST_PLACE_H_

#include "absl/status/status.h"
#include "core/plc/delta.h"
#include "core/plc/plc.h"
#include "dynmesh/options.h"

namespace dynmesh {

// Adds to a RESOURCE_EXHAUSTED error without features the two segments, one of them of `added`,
// between which certainly most vertices are needed: their ids, distance and place. Other statuses,
// and those of meshes that are large for another reason, stay. `present`: the features that `added`
// comes to. O(what is added and near it).
template <int D>
absl::Status NameFinestPlace(absl::Status status, const plc::Delta<D>& added,
                             const plc::Plc<D>& present, const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_FINEST_PLACE_H_
