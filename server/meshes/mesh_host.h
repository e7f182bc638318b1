// One mesh of the server: its single writer, its history for readers, its watchers.
//
// Edits and queries of the DynamicMesh run one at a time on a strand, in the order of submission.
// Everything else is answered from immutable snapshots and never waits for them. A batch that is
// refused, cancelled or stopped changes nothing. With a log, a batch is published and answered
// after it was written to the journal. If the write fails, the batch is undone and refused, and
// readers are served on. If the journal's mesh has another owner, or an append's outcome is
// unknown, the host steps down: it is closed, and all calls get NOT_OWNER.
//
// With a log, small batches are applied ahead of the journal (AppendPipeline). The writer does not
// wait for a sync or a commit: while one group of batches is written by another thread, it applies
// the next group. When the write has ended, the strand settles the group, publishes and answers its
// batches in order, and the next append has all that was applied meanwhile. If it failed, all that
// is held is undone, the last batch first, and refused. A batch alone, with no other behind it, is
// written by the strand's own thread: there is nothing else to do.
//
// What needs the mesh as written waits until nothing is held: a large batch, a revert, a query. It
// waits in the strand's queue and takes no thread (SerialQueue::Defer). So does each batch while
// the limit of what is held is reached. A snapshot for the journal is of the last revision that was
// written, whatever is held; it is made beside the edits (server/journal/snapshots.h).
//
// A host may *follow* a mesh that another server has (mesh_host_following.cc): its revisions are
// those of the journal, made again here and compared by their hashes, and it takes no edits. It
// becomes the owner's host by Lead. Thread-safe: each private member says which thread has it, the
// strand, the writer (of the journal) or any, and the compiler checks that (core/base/mutex.h).
#ifndef DYNMESH_SERVER_MESHES_MESH_HOST_H_
#define DYNMESH_SERVER_MESHES_MESH_HOST_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/access/client_quotas.h"
#include "server/base/memory_guard.h"
#include "server/base/mesh_name.h"
#include "server/base/worker_pool.h"
#include "server/journal/mesh_log.h"
#include "server/journal/shared_journal.h"
#include "server/meshes/append_pipeline.h"
#include "server/meshes/batch_activity.h"
#include "server/meshes/batch_progress.h"
#include "server/meshes/edit_group.h"
#include "server/meshes/edit_job.h"
#include "server/meshes/revision_waiters.h"
#include "server/meshes/watch_hub.h"
#include "server/metrics/server_metrics.h"
#include "server/revisions/request_memory.h"
#include "server/revisions/revision_store.h"

namespace dynmesh::server {

// Makes the mesh of a host; DynamicMesh::Create except in tests.
using MeshFactory = std::function<absl::StatusOr<std::unique_ptr<DynamicMesh>>(
    const MeshOptions&, const ApplyOptions&)>;

class MeshHost : public std::enable_shared_from_this<MeshHost> {
 public:
  struct Options {
    RevisionStore::Limits history;
    WatchHub::Options watch;
    std::size_t max_waiting = 1'000;
    std::size_t remembered_requests = 10'000;
    MeshLog::Limits compact;
    std::shared_ptr<Snapshots> snapshots;  // with a log; null: none are made
    EditMetrics* metrics = nullptr;        // outlives the host; null: nothing is counted
    std::uint64_t max_features = ~std::uint64_t{0};
    std::uint64_t max_operations = 0;     // ApplyOptions::max_operations of every batch
    const MemoryGuard* memory = nullptr;  // outlives the host; null: no limit
    // With a log: what is applied before an append begins, unless one is under way. Large enough
    // that a sync is a small part of its cost.
    SerialQueue::Turn turn = {128, std::chrono::milliseconds(8)};
    AppendPipeline::Limits held;
    // The batches before one that takes longer do not wait for its end.
    MetricsClock::duration long_batch = std::chrono::milliseconds(8);
  };
  // The state of a mesh that is recovered, or is to outlive the process.
  struct Past {
    std::unique_ptr<MeshLog> log;          // null: there is no journal
    std::shared_ptr<RevisionStore> store;  // ends at the mesh; null: begins there
    std::optional<RequestMemory> requests;
    absl::Status read_only;         // not OK: edits are refused with this
    std::optional<MeshHash> empty;  // hash without features; none: there are none
    // Another server has the mesh, and this one follows: the revision of the journal's newest
    // snapshot. There is a log.
    std::optional<std::uint64_t> follows;
  };
  struct LocateAnswer {
    std::uint64_t revision = 0;
    SimplexColumn simplices;
    std::vector<double> leaf_sides;  // of a quadtree
  };

  // Takes `mesh`, O(its size). The pools `writers` and `readers` outlive the host.
  static std::shared_ptr<MeshHost> Create(std::string id, std::unique_ptr<DynamicMesh> mesh,
                                          absl::Time now, WorkerPool* writers, WorkerPool* readers,
                                          const Options& options, Past past = {});
  ~MeshHost();

  // Submits a batch. RESOURCE_EXHAUSTED (QUEUE_FULL), without a call of `done`, if too many wait,
  // or half as many of the job's client (`client` in the metadata).
  absl::Status Apply(EditJob job);
  // The same without that limit, for callers with a limit of their own.
  void ApplyUnbounded(EditJob job);

  // DynamicMesh::Locate, in turn with the edits. `done` is called on the strand or by Withdraw.
  // `cancelled` may be null. `client` as in EditJob; errors as of Apply.
  absl::Status Locate(std::vector<double> points,
                      std::shared_ptr<const std::atomic<bool>> cancelled,
                      std::function<void(absl::StatusOr<LocateAnswer>)> done,
                      absl::string_view client = {});

  // The features at a revision; default: the present one. With a journal they are read on a
  // reader's thread and block no other call. Without one, in turn with the edits and the present
  // ones only (NO_HISTORY). Errors as MeshHistory::At. `done` is called once, unless an error is
  // returned.
  absl::Status Features(std::optional<std::uint64_t> revision,
                        std::shared_ptr<const std::atomic<bool>> cancelled,
                        std::function<void(absl::StatusOr<FeaturesAt>)> done);

  // Removes all jobs with the flag `cancelled`, which is now true, that have not begun. Answers
  // them CANCELLED on this thread.
  void Withdraw(const std::shared_ptr<const std::atomic<bool>>& cancelled) {
    queue_->Withdraw(cancelled.get());
  }

  // Refuses all waiting jobs and ends all watches with `status`; ends the snapshot that is made.
  void Close(const absl::Status& status);
  // Of a host that follows: applies what the journal has after the head, on the strand, then calls
  // `done` there. DATA_LOSS, with the revision: it is another one here than in the journal, and not
  // published; the host is to be dropped. UNIMPLEMENTED: it has other bits than this program's.
  // CANCELLED: the host was closed meanwhile.
  void Follow(SharedJournal::Tail tail, std::function<void(absl::Status)> done);
  // The mesh was claimed, and all that the journal has was applied: it takes edits from now on.
  void Lead() { follows_ = false; }
  bool follows() const { return follows_; }
  // Calls `done` once: with true when the head is `revision` or later, with false at the `end`,
  // when ExpireWaiters tells of it, or when the host is closed. Of a host that follows.
  void WhenAt(std::uint64_t revision, RevisionWaiters::Clock::time_point end,
              RevisionWaiters::Done done);
  void ExpireWaiters(RevisionWaiters::Clock::time_point now) { waiters_.Expire(now); }

  // Of an owner's host: when all that was applied is written, calls `give` on the strand, which may
  // block, and closes the host with NOT_OWNER if it returns the next owner. Batches behind it are
  // refused with that. `done` gets the status of `give`, or why the host was closed before.
  void HandOver(std::function<absl::StatusOr<MeshOwner>()> give,
                std::function<void(absl::Status)> done);

  // Another server may have the mesh: closes the host for good, with NOT_OWNER. `why`: for the log.
  void StepDown(const absl::Status& why);

  const std::string& id() const { return id_; }
  const MeshOptions& mesh_options() const { return mesh_options_; }
  absl::Time create_time() const { return create_time_; }
  Head head() const { return store_->head(); }
  const std::shared_ptr<RevisionStore>& store() const { return store_; }
  const std::shared_ptr<WatchHub>& hub() const { return hub_; }
  const absl::Status& read_only() const { return read_only_; }  // not OK: the reason
  const MeshHistory* history() const { return history_.has_value() ? &*history_ : nullptr; }
  // True once the host has stepped down.
  bool disowned() const { return disowned_; }
  MeshStats stats() const;  // of the head or the revision before it
  std::size_t waiting() const { return queue_->waiting(); }

  // The batch that is applied or written, if there is one.
  using Running = BatchActivity::Running;
  std::optional<Running> running() const { return activity_.running(); }
  // Logs that batch if it has run for more than `interval`; at most once per interval.
  void ReportLongWork(absl::Duration interval) {
    activity_.ReportLongWork(interval, id_, stats().features, waiting());
  }

 private:
  MeshHost(std::string id, std::unique_ptr<DynamicMesh> mesh, absl::Time now, WorkerPool* writers,
           WorkerPool* readers, const Options& options, Past past);

  // A job's task on the strand.
  WorkerPool::Task TaskOf(const std::shared_ptr<EditJob>& job);
  TaskOwner OwnerOf(std::shared_ptr<EditJob> job);
  // A place among those that wait; empty for an empty `client`. Else QUEUE_FULL.
  absl::StatusOr<Share> TakeWaiting(absl::string_view client);
  void WithdrawIfCancelled(const std::shared_ptr<const std::atomic<bool>>& cancelled);
  // Tasks of the strand, and what they call.
  void Run(const std::shared_ptr<EditJob>& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::StatusOr<FeaturesAt> PresentFeatures(std::optional<std::uint64_t> revision) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::StatusOr<EditOutcome> Answer(HeldEdit& edit) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::StatusOr<EditOutcome> Replay(const RequestMemory::Entry& entry) const;
  absl::StatusOr<EditOutcome> Change(HeldEdit& edit, const Fingerprint& content)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::Status CheckRoom(std::size_t adds, std::size_t removes) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::StatusOr<EditOutcome> CheckOnly(const EditJob& job) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::Status Publish(const HeldEdit& edit, const std::shared_ptr<const MeshDiff>& diff)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void Finish(HeldEdit edit) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void SnapshotIfDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void SetProgress(const EditJob& job, const BatchProgress& progress)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);

  // Following (mesh_host_following.cc).
  absl::Status TakeTail(const SharedJournal::Tail& tail) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::Status TakeEntry(const Journal::Entry& entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  absl::Status Remember(const Journal::Request& request) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);

  // The pipeline (mesh_host_appends.cc).
  using FlightPtr = AppendPipeline::FlightPtr;
  // True if the job's turn has come. Else it is deferred until an append has ended.
  bool IsItsTurn(const EditJob& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  // True if the mesh equals the journal's state. Else the running task is deferred as well.
  bool IsWritten() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void Hold(HeldEdit edit) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  FlightPtr BeginFlight() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void BeginAppend() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void AppendAtRest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void EndAppend(const FlightPtr& flight) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void PublishWritten() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void TakeBackHeld(const absl::Status& why) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  void Relieve() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);

  // By the writer: the strand while nothing is in flight, else the thread of the flight, which ends
  // before the next write begins (append_pipeline.h).
  void Write(AppendPipeline::Flight& flight) ABSL_EXCLUSIVE_LOCKS_REQUIRED(log_->writer());
  absl::Status WriteDown(std::span<const MeshLog::Batch> batches, EditSource source)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(log_->writer());

  // By any thread.
  // True if the batch may be applied ahead and written with others.
  bool CanBeHeld(const EditJob& job) const;
  absl::Status Lose(absl::string_view why);
  void RebaseIfDue();
  void Count(const EditJob& job, const absl::StatusOr<EditOutcome>& outcome);
  absl::Status closed() const;

  // For all threads: what never changes, or is thread-safe itself.
  const std::string id_;
  const MeshOptions mesh_options_;
  const absl::Time create_time_;
  const std::size_t max_waiting_;
  ClientQuotas waiting_;  // of those, by client
  EditMetrics* const metrics_;
  const std::uint64_t max_features_, max_operations_;
  const MemoryGuard* const memory_;
  WorkerPool* const writers_;
  WorkerPool* const readers_;
  const MetricsClock::duration long_batch_;
  const std::shared_ptr<SerialQueue> queue_;
  const std::shared_ptr<RevisionStore> store_;
  const std::shared_ptr<WatchHub> hub_;
  const std::optional<MeshHistory> history_;  // none: there is no journal
  const absl::Status read_only_;
  std::atomic<bool> rebasing_{false};
  std::atomic<bool> disowned_{false};
  std::atomic<bool> follows_;
  std::atomic<bool> ended_{false};  // closed: nothing more is to be followed
  RevisionWaiters waiters_;
  BatchActivity activity_;

  // The strand: queue_ runs its tasks one at a time.
  ThreadRole strand_;
  const std::unique_ptr<DynamicMesh> mesh_ ABSL_PT_GUARDED_BY(strand_);
  const std::unique_ptr<MeshLog> log_;  // but appends are the writer's, EndSnapshots any thread's
  RequestMemory requests_ ABSL_GUARDED_BY(strand_);
  AppendPipeline pipeline_ ABSL_GUARDED_BY(strand_);
  // Keeps this alive while the pipeline is not empty.
  std::shared_ptr<MeshHost> while_holding_ ABSL_GUARDED_BY(strand_);
  const std::shared_ptr<Snapshots> snapshots_;
  // A task waits that makes a snapshot from the mesh.
  bool features_asked_ ABSL_GUARDED_BY(strand_) = false;
  // In the journal, while it follows.
  std::uint64_t seen_snapshot_ ABSL_GUARDED_BY(strand_);

  // For readers.
  mutable Mutex mutex_;
  MeshStats stats_ ABSL_GUARDED_BY(mutex_);
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_MESH_HOST_H_
