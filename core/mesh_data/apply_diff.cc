// ApplyDiff of dynmesh/mesh.h, for a mesh held as columns.
#include <utility>

#include "absl/status/status.h"
#include "dynmesh/mesh.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh {

// Stronger than promised: `mesh` is unchanged on failure.
absl::Status ApplyDiff(Mesh& mesh, const MeshDiff& diff) {
  absl::StatusOr<SlotMesh> store = SlotMesh::FromMesh(mesh);
  if (!store.ok()) return store.status();
  if (auto status = store->Apply(diff); !status.ok()) return status;
  mesh = store->ToMesh();
  return absl::OkStatus();
}

}  // namespace dynmesh
