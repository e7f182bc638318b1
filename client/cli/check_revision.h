// Compares a dynamic mesh with one made from scratch of the same features. For --check.
#ifndef DYNMESH_CLIENT_CLI_CHECK_REVISION_H_
#define DYNMESH_CLIENT_CLI_CHECK_REVISION_H_

#include "absl/status/status.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::cli {

// INTERNAL, naming the difference, unless
//   the audit of `mesh` finds nothing,
//   its hash is that of its snapshot and of `replica`, which applied all its diffs,
//   a fresh dynamic mesh with the same features has the same mesh and the same trace,
//   the static path makes the same mesh.
// O(size), several times.
absl::Status CheckRevision(const DynamicMesh& mesh, const SlotMesh& replica);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_CHECK_REVISION_H_
