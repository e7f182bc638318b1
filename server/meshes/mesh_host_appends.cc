// The part of MeshHost that has batches written to the journal while it applies others, and undoes
// them if that fails.
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/mesh_name.h"
#include "server/meshes/mesh_host.h"

namespace dynmesh::server {
namespace {

// A larger batch takes far longer than a sync, so it is written alone.
constexpr std::size_t kMostEditsHeld = 64;

}  // namespace

// A revert reads the mesh, and is undone if its hash differs.
bool MeshHost::CanBeHeld(const EditJob& job) const {
  return log_ != nullptr && job.edits.size() <= kMostEditsHeld && job.make == nullptr &&
         !job.expected_hash.has_value();
}

bool MeshHost::IsItsTurn(const EditJob& job) {
  return (CanBeHeld(job) && !pipeline_.full()) || IsWritten();
}

bool MeshHost::IsWritten() {
  if (pipeline_.empty()) return true;
  BeginAppend();
  queue_->Defer();  // EndAppend lets it run again
  return false;
}

void MeshHost::Hold(HeldEdit edit) {
  if (pipeline_.empty()) while_holding_ = shared_from_this();
  pipeline_.Add(std::move(edit));
  mesh_->SettleAllBut(pipeline_.revisions());  // what Relieve has published meanwhile
}

MeshHost::FlightPtr MeshHost::BeginFlight() {
  FlightPtr flight = pipeline_.Begin();
  const EditJob& first = flight->first();
  activity_.BeginAppend(first);
  if (first.progress != nullptr) first.progress(BatchProgress::Journal());
  return flight;
}

// Has what waits written by another thread, unless an append is under way.
void MeshHost::BeginAppend() {
  if (pipeline_.flight() != nullptr || pipeline_.empty()) return;
  writers_->Post([self = shared_from_this(), flight = BeginFlight()] {
    self->log_->writer().AssertHeld();  // one flight at a time
    self->Write(*flight);
    self->queue_->PostFirst([self, flight] {
      self->strand_.AssertHeld();
      self->EndAppend(flight);
    });
  });
}

// A batch alone is written by this thread: that wakes no other, and no task waits for this one.
void MeshHost::AppendAtRest() {
  const bool alone = pipeline_.flight() == nullptr && pipeline_.waiting() == 1;
  if (!alone || queue_->waiting() > 0) return BeginAppend();
  const FlightPtr flight = BeginFlight();
  log_->writer().AssertHeld();  // this flight is the only one
  Write(*flight);
  EndAppend(flight);
}

void MeshHost::Write(AppendPipeline::Flight& flight) {
  flight.End(WriteDown(flight.batches(), flight.first().source));
}

// After Write.
void MeshHost::EndAppend(const FlightPtr& flight) {
  if (pipeline_.flight() != flight) return;  // Relieve has seen its end
  if (!flight->written().ok()) return TakeBackHeld(flight->written());
  PublishWritten();
  mesh_->SettleAllBut(pipeline_.revisions());
  SnapshotIfDue();
}

// After a write. Its memory comes on top of the meshes', so it waits while these may
// not grow.
void MeshHost::SnapshotIfDue() {
  if (log_ == nullptr || snapshots_ == nullptr || features_asked_ || !log_->IsDue(*mesh_)) return;
  if (ended_ || (memory_ != nullptr && memory_->full()->load())) return;
  if (!log_->needs_features()) return log_->OrderSnapshot(*snapshots_);
  features_asked_ = true;
  queue_->Post([self = shared_from_this()] {
    self->strand_.AssertHeld();
    if (!self->IsWritten()) return;
    self->features_asked_ = false;
    if (self->ended_ || !self->log_->IsDue(*self->mesh_)) return;
    self->log_->OrderSnapshot(*self->snapshots_, *self->mesh_);
  });
}

// After a write that succeeded. Does not use the mesh.
void MeshHost::PublishWritten() {
  activity_.EndAppend();
  std::vector<HeldEdit> edits = pipeline_.TakeWritten();
  if (pipeline_.empty()) while_holding_ = nullptr;
  for (HeldEdit& edit : edits) {
    if (!edit.unwritten) continue;
    if (absl::Status s = Publish(edit, edit.outcome->diff); !s.ok()) edit.outcome = std::move(s);
  }
  // The journal is not to wait for the answers. What waits alone may be written at rest.
  if (pipeline_.waiting() > 1 || queue_->waiting() > 0) BeginAppend();
  for (HeldEdit& edit : edits) Finish(std::move(edit));
  hub_->Notify();
  RebaseIfDue();
}

// After a write that failed. No client has seen the effects of what is held.
void MeshHost::TakeBackHeld(const absl::Status& why) {
  activity_.EndAppend();
  mesh_->TakeBack(pipeline_.revisions());
  mesh_->Settle();
  const Head head = store_->head();
  if (mesh_->revision() != head.revision || mesh_->hash() != head.hash) {
    Lose(absl::StrCat("taken back to revision ", head.revision, " it has the hash ",
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
    Finish(std::move(edit));
  }
  while_holding_ = nullptr;
}

// Called while a batch is applied. If it runs long, the batches before it do not wait for its end.
// The mesh is in the middle of that batch and cannot undo: a failed write waits.
void MeshHost::Relieve() {
  if (pipeline_.empty() || activity_.applying() < long_batch_) return;
  const FlightPtr flight = pipeline_.flight();
  if (flight != nullptr && flight->ended() && flight->written().ok()) PublishWritten();
  BeginAppend();
}

}  // namespace dynmesh::server
