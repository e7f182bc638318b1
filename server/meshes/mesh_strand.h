// When the requests for a mesh have their turn, and which of them wait. No lock guards a mesh: all
// that uses it is a task here, and they run one at a time, in the order of their posting.
//
// A task that finds what it needs not yet written gives its thread back (Defer), and runs again
// after the next task of PostFirst: the end of an append (MeshWriter). Tasks of one call can be
// withdrawn until they begin. What waits is limited, in all and for each client.
//
// Thread-safe. Tasks begin with AssertHeld of role(): for the check of locks, what they call is on
// the strand.
#ifndef DYNMESH_SERVER_MESHES_MESH_STRAND_H_
#define DYNMESH_SERVER_MESHES_MESH_STRAND_H_

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/base/mutex.h"
#include "server/access/client_quotas.h"
#include "server/base/worker_pool.h"

namespace dynmesh::server {

class MeshStrand {
 public:
  using Task = SerialQueue::Task;
  // True after the call was cancelled. May be null.
  using Cancelled = std::shared_ptr<const std::atomic<bool>>;

  // `pool` outlives it. `max_waiting`: for Take and TryPost.
  MeshStrand(WorkerPool* pool, const SerialQueue::Turn& turn, std::size_t max_waiting);

  // A place among those that wait; empty for an empty `client`. QUEUE_FULL: the client has half of
  // `max_waiting`.
  absl::StatusOr<Share> Take(absl::string_view client);

  // `task` in its turn, or `owner`'s function if it is withdrawn before. TryPost: QUEUE_FULL, and
  // neither, if too many wait.
  absl::Status TryPost(Task task, TaskOwner owner = {});
  void Post(Task task, TaskOwner owner = {}) { queue_->Post(std::move(task), std::move(owner)); }
  // Ahead of all tasks of Post and TryPost, deferred ones as well.
  void PostFirst(Task task) { queue_->PostFirst(std::move(task)); }

  // Withdraws all tasks with the owner `cancelled` that have not begun, if that is true now.
  void WithdrawIf(const Cancelled& cancelled) {
    if (cancelled != nullptr && cancelled->load()) queue_->Withdraw(cancelled.get());
  }
  void Withdraw(const Cancelled& cancelled) { queue_->Withdraw(cancelled.get()); }

  // SerialQueue::Defer: the running task runs again after the next task of PostFirst.
  void Defer() ABSL_EXCLUSIVE_LOCKS_REQUIRED(role_) { queue_->Defer(); }
  // `rest` runs on the strand before it pauses. To be called before any task is posted.
  void OnRest(Task rest) { queue_->OnRest(std::move(rest)); }

  std::size_t waiting() const { return queue_->waiting(); }
  // The part of the thread that runs a task.
  const ThreadRole& role() const ABSL_LOCK_RETURNED(role_) { return role_; }

 private:
  const std::size_t max_waiting_;
  ClientQuotas clients_;  // of those that wait
  const std::shared_ptr<SerialQueue> queue_;
  ThreadRole role_;
};

// The answer to what was withdrawn.
absl::Status CancelledInTime();

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_MESH_STRAND_H_
