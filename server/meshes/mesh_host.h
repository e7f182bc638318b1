// One mesh of the server, as its callers have it. A batch goes through three parts, each of which
// has a file and says which threads may use it:
//
//   Apply, by any thread -> MeshStrand: its turn, on the strand
//     -> Run, here: judged (retries, expected revision, limits) and applied to the DynamicMesh
//     -> MeshWriter: written to the journal, with others or alone; then published
//     -> EditJob::done: the answer
//     -> MeshReaders: the watchers are woken
//
// A batch that is refused, cancelled or stopped changes nothing. With a log, a batch is published
// and answered after it was written to the journal. If the write fails, the batch is undone and
// refused, and readers are served on. If the journal's mesh has another owner, or an append's
// outcome is unknown, the host steps down: it is closed, and all calls get NOT_OWNER. Queries of
// the mesh are tasks of the strand, too; everything else is answered from immutable snapshots and
// never waits.
//
// A host may *follow* a mesh that another server has (mesh_host_following.cc): its revisions are
// those of the journal, made again here and compared by their hashes, and it takes no edits. It
// becomes the owner's host by Lead. Thread-safe: a private member that is not for any thread says
// that it is the strand's, and the compiler checks that (core/base/mutex.h).
#ifndef DYNMESH_SERVER_MESHES_MESH_HOST_H_
#define DYNMESH_SERVER_MESHES_MESH_HOST_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
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
#include "server/meshes/mesh_readers.h"
#include "server/meshes/mesh_strand.h"
#include "server/meshes/mesh_writer.h"
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
    strand_->Withdraw(cancelled);
  }

  // Refuses all waiting jobs and ends all watches with `status`; ends the snapshot that is made.
  void Close(const absl::Status& status) { writer_->Close(status); }
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
              RevisionWaiters::Done done) {
    readers_->WhenAt(revision, end, std::move(done));
  }
  void ExpireWaiters(RevisionWaiters::Clock::time_point now) { readers_->ExpireWaiters(now); }

  // Of an owner's host: when all that was applied is written, calls `give` on the strand, which may
  // block, and closes the host with NOT_OWNER if it returns the next owner. Batches behind it are
  // refused with that. `done` gets the status of `give`, or why the host was closed before.
  void HandOver(std::function<absl::StatusOr<MeshOwner>()> give,
                std::function<void(absl::Status)> done);

  // Another server may have the mesh: closes the host for good, with NOT_OWNER. `why`: for the log.
  void StepDown(const absl::Status& why) { writer_->StepDown(why); }

  const std::string& id() const { return id_; }
  const MeshOptions& mesh_options() const { return mesh_options_; }
  absl::Time create_time() const { return create_time_; }
  Head head() const { return readers_->head(); }
  const std::shared_ptr<RevisionStore>& store() const { return readers_->store(); }
  const std::shared_ptr<WatchHub>& hub() const { return readers_->hub(); }
  const absl::Status& read_only() const { return read_only_; }  // not OK: the reason
  const MeshHistory* history() const { return readers_->history(); }
  // True once the host has stepped down.
  bool disowned() const { return writer_->disowned(); }
  MeshStats stats() const { return readers_->stats(); }  // of the head or the revision before it
  std::size_t waiting() const { return strand_->waiting(); }

  // The batch that is applied or written, if there is one.
  using Running = BatchActivity::Running;
  std::optional<Running> running() const { return writer_->activity().running(); }
  // Logs that batch if it has run for more than `interval`; at most once per interval.
  void ReportLongWork(absl::Duration interval) {
    writer_->activity().ReportLongWork(interval, id_, stats().features, waiting());
  }

 private:
  MeshHost(std::string id, std::unique_ptr<DynamicMesh> mesh, absl::Time now, WorkerPool* writers,
           WorkerPool* readers, const Options& options, Past past);

  // A job's task on the strand.
  WorkerPool::Task TaskOf(const std::shared_ptr<EditJob>& job);
  TaskOwner OwnerOf(std::shared_ptr<EditJob> job);

  // Tasks of the strand, and what they call. Its role has the writer's name for it.
  void Run(const std::shared_ptr<EditJob>& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  absl::StatusOr<FeaturesAt> PresentFeatures(std::optional<std::uint64_t> revision) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  absl::StatusOr<EditOutcome> Judge(HeldEdit& edit)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  absl::StatusOr<EditOutcome> Replay(const RequestMemory::Entry& entry) const;
  absl::StatusOr<EditOutcome> Change(HeldEdit& edit, const Fingerprint& content)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  absl::Status CheckRoom(std::size_t adds, std::size_t removes) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  absl::StatusOr<EditOutcome> CheckOnly(const EditJob& job) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  void SetProgress(const EditJob& job, const BatchProgress& progress)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());

  // Following (mesh_host_following.cc).
  absl::Status TakeTail(const SharedJournal::Tail& tail)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  absl::Status TakeEntry(const Journal::Entry& entry)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());
  absl::Status Remember(const Journal::Request& request)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_->strand());

  // For all threads: what never changes, or is thread-safe itself.
  const std::string id_;
  const MeshOptions mesh_options_;
  const absl::Time create_time_;
  const std::uint64_t max_features_, max_operations_;
  const MemoryGuard* const memory_;
  const absl::Status read_only_;
  const bool has_log_;
  std::atomic<bool> follows_;
  const std::shared_ptr<MeshStrand> strand_;
  const std::shared_ptr<MeshReaders> readers_;

  // The strand's; the writer's, which undoes batches.
  DynamicMesh* const mesh_ ABSL_PT_GUARDED_BY(writer_->strand());
  const std::shared_ptr<MeshWriter> writer_;
  // In the journal, while it follows.
  std::uint64_t seen_snapshot_ ABSL_GUARDED_BY(writer_->strand());
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_MESH_HOST_H_
