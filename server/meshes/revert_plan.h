// Revert to an earlier revision as a batch of edits: the difference between the present features
// and those of the revision. It is read from the journal and computed on a reader's thread. Only if
// edits came in between is it computed again, in the job's turn. Thread-safe.
#ifndef DYNMESH_SERVER_MESHES_REVERT_PLAN_H_
#define DYNMESH_SERVER_MESHES_REVERT_PLAN_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "server/meshes/mesh_host.h"

namespace dynmesh::server {

struct RevertPlan {
  EditJob job;             // without request_id, callbacks and the like
  std::size_t weight = 0;  // of the edits
};

// O(features). An error about `revision` is reported by the job in its turn: a retry must get its
// first answer even if the revision is no longer available.
RevertPlan PlanRevert(const MeshHost& host, std::uint64_t revision,
                      std::shared_ptr<const std::atomic<bool>> cancelled);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_REVERT_PLAN_H_
