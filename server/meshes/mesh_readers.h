// What a mesh's readers see: its published revisions, the watchers of them, and those that wait for
// one. Never the mesh itself: a reader waits for no edit.
//
// The strand publishes (Append) and then wakes the watchers (Notify), which is apart from it, as
// the batch is answered in between. All else is for any thread.
#ifndef DYNMESH_SERVER_MESHES_MESH_READERS_H_
#define DYNMESH_SERVER_MESHES_MESH_READERS_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/base/worker_pool.h"
#include "server/journal/mesh_history.h"
#include "server/meshes/revision_waiters.h"
#include "server/meshes/watch_hub.h"
#include "server/revisions/revision_store.h"

namespace dynmesh::server {

class MeshReaders : public std::enable_shared_from_this<MeshReaders> {
 public:
  // `store` ends at the revision that has these `stats`. `history`: of the journal; none: there is
  // no journal. `pool` outlives it.
  static std::shared_ptr<MeshReaders> Create(std::string id, std::shared_ptr<RevisionStore> store,
                                             std::optional<MeshHistory> history,
                                             const MeshStats& stats, WorkerPool* pool,
                                             const WatchHub::Options& watch);
  // Ends the watches.
  ~MeshReaders();

  // Publishes the next revision, which has these `stats`. Errors as RevisionStore::Append.
  absl::Status Append(const std::shared_ptr<const MeshDiff>& diff, const MeshStats& stats);
  // Wakes the watchers after Append, and has a new base of the revisions made when one is due.
  void Notify();
  // Calls back those of WhenAt that wait for the head or an earlier revision.
  void TellWaiters() { waiters_.Reached(head().revision); }

  // Ends all watches and waiting with `status`, which is not OK.
  void Close(const absl::Status& status);
  absl::Status closed() const;                                           // OK: it is open
  bool ended() const { return ended_.load(std::memory_order_relaxed); }  // the same, without a lock

  Head head() const { return store_->head(); }
  const std::shared_ptr<RevisionStore>& store() const { return store_; }
  const std::shared_ptr<WatchHub>& hub() const { return hub_; }
  const MeshHistory* history() const { return history_.has_value() ? &*history_ : nullptr; }
  MeshStats stats() const;  // of the head or the revision before it

  // The features at a revision, from the journal, on a reader's thread; default: the head's.
  // REQUIRES: history().
  void FeaturesAtRevision(std::optional<std::uint64_t> revision,
                          std::shared_ptr<const std::atomic<bool>> cancelled,
                          std::function<void(absl::StatusOr<FeaturesAt>)> done);
  // Calls `done` once: with true when the head is `revision` or later, with false at the `end`,
  // when ExpireWaiters tells of it, or at Close.
  void WhenAt(std::uint64_t revision, RevisionWaiters::Clock::time_point end,
              RevisionWaiters::Done done);
  void ExpireWaiters(RevisionWaiters::Clock::time_point now) { waiters_.Expire(now); }

 private:
  MeshReaders(std::string id, std::shared_ptr<RevisionStore> store,
              std::optional<MeshHistory> history, const MeshStats& stats, WorkerPool* pool,
              const WatchHub::Options& watch);
  void RebaseIfDue();

  const std::string id_;
  WorkerPool* const pool_;
  const std::shared_ptr<RevisionStore> store_;
  const std::shared_ptr<WatchHub> hub_;
  const std::optional<MeshHistory> history_;
  RevisionWaiters waiters_;
  std::atomic<bool> rebasing_{false};
  std::atomic<bool> ended_{false};
  mutable Mutex mutex_;
  MeshStats stats_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_MESH_READERS_H_
