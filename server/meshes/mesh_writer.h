// From an applied batch to its answer: the writer of a mesh's journal.
//
// Without a journal, or for a large batch, that is short: the batch is written alone (WriteAlone)
// while it is applied, published, and answered. Small batches are applied ahead of the journal and
// held (Hold; AppendPipeline). The strand does not wait for a sync or a commit: while one group of
// batches is written by another thread, it applies the next group.
//
//   strand:   Hold, Hold, BeginAppend .. Hold, Hold .. EndAppend: publish, BeginAppend, answer,
//   wake a thread of the pool:  [ Write the first group ]                  [ Write the next group ]
//
// If a write fails, all that is held is undone, the last batch first, and refused (TakeBackHeld). A
// batch alone, with no other behind it, is written by the strand's own thread: there is nothing
// else to do (AppendAtRest).
//
// What needs the mesh as written waits until nothing is held (IsWritten): a large batch, a revert,
// a query. So does each batch while the limit of what is held is reached (IsItsTurn). It waits in
// the strand's queue and takes no thread. A snapshot for the journal is of the last revision that
// was written, whatever is held; it is made beside the edits (server/journal/snapshots.h).
//
// The writer has the mesh and lives while it holds something. Each member says which thread has it:
// the strand, the journal's writer or any; the compiler checks that (core/base/mutex.h).
#ifndef DYNMESH_SERVER_MESHES_MESH_WRITER_H_
#define DYNMESH_SERVER_MESHES_MESH_WRITER_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/base/mutex.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/base/memory_guard.h"
#include "server/base/worker_pool.h"
#include "server/journal/mesh_log.h"
#include "server/meshes/append_pipeline.h"
#include "server/meshes/batch_activity.h"
#include "server/meshes/edit_group.h"
#include "server/meshes/edit_job.h"
#include "server/meshes/mesh_readers.h"
#include "server/meshes/mesh_strand.h"
#include "server/metrics/server_metrics.h"
#include "server/revisions/request_memory.h"

namespace dynmesh::server {

class MeshWriter : public std::enable_shared_from_this<MeshWriter> {
 public:
  // As in MeshHost::Options.
  struct Options {
    AppendPipeline::Limits held;
    MetricsClock::duration long_batch{};
    std::shared_ptr<Snapshots> snapshots;
    EditMetrics* metrics = nullptr;
    const MemoryGuard* memory = nullptr;
  };

  // `log`: null if there is no journal. `requests`: what was answered before. `pool` outlives it.
  static std::shared_ptr<MeshWriter> Create(std::string id, std::unique_ptr<DynamicMesh> mesh,
                                            std::shared_ptr<MeshStrand> strand,
                                            std::shared_ptr<MeshReaders> readers,
                                            std::unique_ptr<MeshLog> log, RequestMemory requests,
                                            WorkerPool* pool, const Options& options);

  // --- by the strand
  const ThreadRole& strand() const ABSL_LOCK_RETURNED(strand_->role()) { return strand_->role(); }

  // True if the job's turn has come. Else the running task is deferred until an append has ended.
  bool IsItsTurn(const EditJob& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  // True if the mesh equals the journal's state. Else the running task is deferred as well.
  bool IsWritten() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  // The answer to the request, if it is known; null: it is not.
  const RequestMemory::Entry* FindAnswered(absl::string_view request_id) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role()) {
    return requests_.Find(request_id);
  }
  // The batch of that request, if it was applied and is held; null: it is not.
  const HeldEdit* FindHeld(absl::string_view request_id) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role()) {
    return pipeline_.Find(request_id);
  }
  void Remember(std::string request_id, const RequestMemory::Entry& answer)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role()) {
    requests_.Remember(std::move(request_id), answer);
  }

  // Writes a batch that is applied and not held. REQUIRES: it was its turn; there is a log.
  absl::Status WriteAlone(const EditJob& job, const RequestMemory::Entry& answer)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  // Publishes a batch that is written, or needs not be.
  absl::Status Publish(const HeldEdit& edit, const std::shared_ptr<const MeshDiff>& diff)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  // Takes over an outcome: answers it at once, or once all that is held before it is written.
  // `is_new`: the batch made a revision.
  void Settle(HeldEdit edit, bool is_new) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  // Called while a batch is applied. If it runs long, those before it do not wait for its end.
  void PublishMeanwhile() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());

  // --- by any thread
  // True if the batch may be applied ahead and written with others.
  bool CanBeHeld(const EditJob& job) const;
  void Count(const EditJob& job, const absl::StatusOr<EditOutcome>& outcome);
  BatchActivity& activity() { return activity_; }
  const BatchActivity& activity() const { return activity_; }
  // Null: there is no journal.
  MeshLog* log() { return log_.get(); }

  // Closes the readers with `status`, and ends the snapshot that is made.
  void Close(const absl::Status& status);
  // The mesh broke an invariant. Readers keep the last good state. Returns the error that closed
  // it.
  absl::Status CloseBroken(absl::string_view why);
  // The journal is no longer this mesh's: another server may write to it. Closes with NOT_OWNER.
  void StepDown(const absl::Status& why);
  // The same of a mesh that was given away; `status` is NOT_OWNER.
  void GiveUp(const absl::Status& status);
  // True once it has stepped down or was given away.
  bool disowned() const { return disowned_; }

 private:
  using FlightPtr = AppendPipeline::FlightPtr;

  MeshWriter(std::string id, std::unique_ptr<DynamicMesh> mesh, std::shared_ptr<MeshStrand> strand,
             std::shared_ptr<MeshReaders> readers, std::unique_ptr<MeshLog> log,
             RequestMemory requests, WorkerPool* pool, const Options& options);

  void Hold(HeldEdit edit) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  FlightPtr BeginFlight() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  void BeginAppend() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  void AppendAtRest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  void EndAppend(const FlightPtr& flight) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  void PublishWritten() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  void TakeBackHeld(const absl::Status& why) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  void SnapshotIfDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());
  void Answer(HeldEdit edit) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_->role());

  // By the journal's writer: the strand while nothing is in flight, else the thread of the flight,
  // which ends before the next write begins (append_pipeline.h).
  void Write(AppendPipeline::Flight& flight) ABSL_EXCLUSIVE_LOCKS_REQUIRED(log_->writer());
  absl::Status WriteDown(std::span<const MeshLog::Batch> batches, EditSource source)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(log_->writer());

  // For all threads: what never changes, or is thread-safe itself.
  const std::string id_;
  WorkerPool* const pool_;
  const MetricsClock::duration long_batch_;
  EditMetrics* const metrics_;
  const MemoryGuard* const memory_;
  const std::shared_ptr<Snapshots> snapshots_;
  const std::shared_ptr<MeshStrand> strand_;
  const std::shared_ptr<MeshReaders> readers_;
  BatchActivity activity_;
  std::atomic<bool> disowned_{false};

  // The strand's.
  const std::unique_ptr<DynamicMesh> mesh_ ABSL_PT_GUARDED_BY(strand_->role());
  const std::unique_ptr<MeshLog> log_;  // but appends are the writer's, EndSnapshots any thread's
  RequestMemory requests_ ABSL_GUARDED_BY(strand_->role());
  AppendPipeline pipeline_ ABSL_GUARDED_BY(strand_->role());
  // Keeps this alive while the pipeline is not empty.
  std::shared_ptr<MeshWriter> while_holding_ ABSL_GUARDED_BY(strand_->role());
  // A task waits that makes a snapshot from the mesh.
  bool features_asked_ ABSL_GUARDED_BY(strand_->role()) = false;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_MESH_WRITER_H_
