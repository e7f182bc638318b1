#include "server/meshes/mesh_writer.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"

namespace dynmesh::server {
namespace {

// A larger batch takes far longer than a sync, so it is written alone.
constexpr std::size_t kMostEditsHeld = 64;

}  // namespace

std::shared_ptr<MeshWriter> MeshWriter::Create(std::string id, std::unique_ptr<DynamicMesh> mesh,
                                               std::shared_ptr<MeshStrand> strand,
                                               std::shared_ptr<MeshReaders> readers,
                                               std::unique_ptr<MeshLog> log, RequestMemory requests,
                                               WorkerPool* pool, const Options& options) {
  std::shared_ptr<MeshWriter> writer(
      new MeshWriter(std::move(id), std::move(mesh), std::move(strand), std::move(readers),
                     std::move(log), std::move(requests), pool, options));
  if (writer->log_ != nullptr) {
    writer->strand_->OnRest([weak = std::weak_ptr(writer)] {
      const auto held = weak.lock();
      if (held == nullptr) return;
      held->strand_->role().AssertHeld();
      held->AppendAtRest();
    });
  }
  return writer;
}

MeshWriter::MeshWriter(std::string id, std::unique_ptr<DynamicMesh> mesh,
                       std::shared_ptr<MeshStrand> strand, std::shared_ptr<MeshReaders> readers,
                       std::unique_ptr<MeshLog> log, RequestMemory requests, WorkerPool* pool,
                       const Options& options)
    : id_(std::move(id)),
      pool_(pool),
      long_batch_(options.long_batch),
      metrics_(options.metrics),
      memory_(options.memory),
      snapshots_(options.snapshots),
      strand_(std::move(strand)),
      readers_(std::move(readers)),
      mesh_(std::move(mesh)),
      log_(std::move(log)),
      requests_(std::move(requests)),
      pipeline_(options.held) {}

// --- turns

// A revert reads the mesh, and is undone if its hash differs.
bool MeshWriter::CanBeHeld(const EditJob& job) const {
  return log_ != nullptr && job.edits.size() <= kMostEditsHeld && job.make == nullptr &&
         !job.expected_hash.has_value();
}

bool MeshWriter::IsItsTurn(const EditJob& job) {
  return (CanBeHeld(job) && !pipeline_.full()) || IsWritten();
}

bool MeshWriter::IsWritten() {
  if (pipeline_.empty()) return true;
  BeginAppend();
  strand_->Defer();  // EndAppend lets it run again
  return false;
}

// --- from the outcome to the journal

void MeshWriter::Settle(HeldEdit edit, bool is_new) {
  if (edit.unwritten || !pipeline_.empty()) return Hold(std::move(edit));
  // Answer the writer's caller first: the watchers' threads would compete with it.
  Answer(std::move(edit));
  if (!is_new) return;
  readers_->Notify();
  SnapshotIfDue();
}

void MeshWriter::Hold(HeldEdit edit) {
  if (pipeline_.empty()) while_holding_ = shared_from_this();
  pipeline_.Add(std::move(edit));
  mesh_->SettleAllBut(pipeline_.revisions());  // what PublishMeanwhile has published
}

MeshWriter::FlightPtr MeshWriter::BeginFlight() {
  FlightPtr flight = pipeline_.Begin();
  const EditJob& first = flight->first();
  activity_.BeginAppend(first);
  if (first.progress != nullptr) first.progress(BatchProgress::Journal());
  return flight;
}

// Has what waits written by another thread, unless an append is under way.
void MeshWriter::BeginAppend() {
  if (pipeline_.flight() != nullptr || pipeline_.empty()) return;
  pool_->Post([self = shared_from_this(), flight = BeginFlight()] {
    self->log_->writer().AssertHeld();  // one flight at a time
    self->Write(*flight);
    self->strand_->PostFirst([self, flight] {
      self->strand_->role().AssertHeld();
      self->EndAppend(flight);
    });
  });
}

// A batch alone is written by this thread: that wakes no other, and no task waits for this one.
void MeshWriter::AppendAtRest() {
  const bool alone = pipeline_.flight() == nullptr && pipeline_.waiting() == 1;
  if (!alone || strand_->waiting() > 0) return BeginAppend();
  const FlightPtr flight = BeginFlight();
  log_->writer().AssertHeld();  // this flight is the only one
  Write(*flight);
  EndAppend(flight);
}

void MeshWriter::Write(AppendPipeline::Flight& flight) {
  flight.End(WriteDown(flight.batches(), flight.first().source));
}

absl::Status MeshWriter::WriteAlone(const EditJob& job, const RequestMemory::Entry& answer) {
  log_->writer().AssertHeld();  // nothing is in flight: it was this batch's turn
  const MeshLog::Batch alone{&job.edits, job.request_id, answer};
  return WriteDown({&alone, 1}, job.source);
}

absl::Status MeshWriter::WriteDown(std::span<const MeshLog::Batch> batches, EditSource source) {
  if (disowned_) return NotOwnerError(id_);
  const auto start = MetricsClock::now();
  absl::Status written = log_->Append(batches);
  if (metrics_ != nullptr) metrics_->of(source).journal.Observe(SecondsSince(start));
  if (!log_->owns()) StepDown(written);
  return written;
}

// --- from the journal to the answers

// After Write.
void MeshWriter::EndAppend(const FlightPtr& flight) {
  if (pipeline_.flight() != flight) return;  // PublishMeanwhile has seen its end
  if (!flight->written().ok()) return TakeBackHeld(flight->written());
  PublishWritten();
  mesh_->SettleAllBut(pipeline_.revisions());
  SnapshotIfDue();
}

// After a write that succeeded. Does not use the mesh.
void MeshWriter::PublishWritten() {
  activity_.EndAppend();
  std::vector<HeldEdit> edits = pipeline_.TakeWritten();
  if (pipeline_.empty()) while_holding_ = nullptr;
  for (HeldEdit& edit : edits) {
    if (!edit.unwritten) continue;
    if (absl::Status s = Publish(edit, edit.outcome->diff); !s.ok()) edit.outcome = std::move(s);
  }
  // The journal is not to wait for the answers. What waits alone may be written at rest.
  if (pipeline_.waiting() > 1 || strand_->waiting() > 0) BeginAppend();
  for (HeldEdit& edit : edits) Answer(std::move(edit));
  readers_->Notify();
}

absl::Status MeshWriter::Publish(const HeldEdit& edit,
                                 const std::shared_ptr<const MeshDiff>& diff) {
  if (diff->from_revision != diff->to_revision) {
    if (absl::Status status = readers_->Append(diff, edit.stats); !status.ok()) {
      return CloseBroken(status.message());
    }
  }
  if (!edit.job->request_id.empty()) requests_.Remember(edit.job->request_id, edit.answer);
  return absl::OkStatus();
}

// After a write that failed. No client has seen the effects of what is held.
void MeshWriter::TakeBackHeld(const absl::Status& why) {
  activity_.EndAppend();
  mesh_->TakeBack(pipeline_.revisions());
  mesh_->Settle();
  const Head head = readers_->head();
  if (mesh_->revision() != head.revision || mesh_->hash() != head.hash) {
    CloseBroken(absl::StrCat("taken back to revision ", head.revision, " it has the hash ",
                             mesh_->hash().ToHex(), ", not ", head.hash.ToHex()))
        .IgnoreError();
  }
  // What was not handed to the journal has no unknown outcome.
  log_->writer().AssertHeld();  // the flight has ended, and no other has begun
  const absl::Status behind = log_->owns() ? why : NotOwnerError(id_);
  std::size_t flown = 0;
  for (HeldEdit& edit : pipeline_.TakeAll(&flown)) {
    if (edit.judged) edit.outcome = flown > 0 ? why : behind;
    if (flown > 0) --flown;
    if (edit.job->stop != nullptr && !edit.outcome.ok()) edit.job->stop->store(true);
    Answer(std::move(edit));
  }
  while_holding_ = nullptr;
}

// The mesh is in the middle of a batch and cannot undo: a failed write waits.
void MeshWriter::PublishMeanwhile() {
  if (pipeline_.empty() || activity_.applying() < long_batch_) return;
  const FlightPtr flight = pipeline_.flight();
  if (flight != nullptr && flight->ended() && flight->written().ok()) PublishWritten();
  BeginAppend();
}

void MeshWriter::Answer(HeldEdit edit) {
  EditJob& job = *edit.job;
  Count(job, edit.outcome);
  if (LogEnabled(LogLevel::kDebug)) {
    Log(LogLevel::kDebug, "edit",
        {{"mesh", id_},
         {"call", job.call_id},
         {"request_id", job.request_id},
         {"edits", job.edits.size()},
         {"revision",
          edit.outcome.ok() ? edit.outcome->diff->to_revision : readers_->head().revision},
         {"status", absl::StatusCodeToString(edit.outcome.status().code())},
         {"message", edit.outcome.status().message()}});
  }
  job.done(std::move(edit.outcome));
}

void MeshWriter::Count(const EditJob& job, const absl::StatusOr<EditOutcome>& outcome) {
  if (metrics_ == nullptr) return;
  if (!outcome.ok()) return metrics_->CountAnswer(outcome.status(), EditMetrics::Kind::kApplied);
  const auto kind = outcome->replayed   ? EditMetrics::Kind::kReplayed
                    : job.validate_only ? EditMetrics::Kind::kValidated
                                        : EditMetrics::Kind::kApplied;
  metrics_->CountAnswer(absl::OkStatus(), kind);
  if (kind == EditMetrics::Kind::kApplied) metrics_->ObserveWork(outcome->diff->work, job.source);
}

// After a write. Its memory comes on top of the meshes', so it waits while these may
// not grow.
void MeshWriter::SnapshotIfDue() {
  if (log_ == nullptr || snapshots_ == nullptr || features_asked_ || !log_->IsDue(*mesh_)) return;
  if (readers_->ended() || (memory_ != nullptr && memory_->full()->load())) return;
  if (!log_->needs_features()) return log_->OrderSnapshot(*snapshots_);
  features_asked_ = true;
  strand_->Post([self = shared_from_this()] {
    self->strand_->role().AssertHeld();
    if (!self->IsWritten()) return;
    self->features_asked_ = false;
    if (self->readers_->ended() || !self->log_->IsDue(*self->mesh_)) return;
    self->log_->OrderSnapshot(*self->snapshots_, *self->mesh_);
  });
}

// --- the end

void MeshWriter::Close(const absl::Status& status) {
  readers_->Close(status);
  if (log_ != nullptr) log_->EndSnapshots();
}

absl::Status MeshWriter::CloseBroken(absl::string_view why) {
  Log(LogLevel::kError, "lost_revision", {{"mesh", id_}, {"error", why}});
  const absl::Status lost =
      absl::InternalError(absl::StrCat("mesh ", id_, " can no longer be followed: ", why));
  Close(lost);
  return lost;
}

void MeshWriter::StepDown(const absl::Status& why) {
  if (disowned_.exchange(true)) return;
  Log(LogLevel::kWarning, "mesh_disowned", {{"mesh", id_}, {"error", why.message()}});
  Close(NotOwnerError(id_));
}

void MeshWriter::GiveUp(const absl::Status& status) {
  disowned_ = true;
  Close(status);
}

}  // namespace dynmesh::server
