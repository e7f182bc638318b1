// Going back to an earlier revision as a batch of edits: what is between the features of now and of
// then. Read in the journal and compared on a reader's thread; only if edits came in between is it
// compared again, in the job's turn. Thread-safe.
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

// O(features). What is wrong with the revision the job says in its turn: a retry is answered as the
// first time, whatever became of the revision since.
RevertPlan PlanRevert(const MeshHost& host, std::uint64_t revision,
                      std::shared_ptr<const std::atomic<bool>> cancelled);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_REVERT_PLAN_H_
