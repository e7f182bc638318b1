// The part of MeshHost that ends a group: writes it to the journal, or undoes it.
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
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

void MeshHost::EndGroup() {
  if (group_.empty()) return;
  const EditJob& first = *group_.front().job;
  SetRunning(&first);
  SetProgress(first, BatchProgress::Journal());
  const absl::Status written = WriteDown(group_.Unwritten(), first.source);
  SetRunning(nullptr);
  if (!written.ok()) return TakeBackGroup(written);
  mesh_->Settle();
  PublishGroup();
  log_->CompactIfDue(*mesh_);
}

// After the group was written.
void MeshHost::PublishGroup() {
  const std::shared_ptr<MeshHost> self = std::move(while_holding_);
  std::vector<HeldEdit> edits = group_.Take();
  for (HeldEdit& edit : edits) {
    if (!edit.unwritten) continue;
    if (absl::Status s = Publish(edit, edit.outcome->diff); !s.ok()) edit.outcome = std::move(s);
  }
  for (HeldEdit& edit : edits) Finish(std::move(edit));
  hub_->Notify();
  RebaseIfDue();
}

// After the write failed. No client has seen the group's effects.
void MeshHost::TakeBackGroup(const absl::Status& why) {
  const std::shared_ptr<MeshHost> self = std::move(while_holding_);
  mesh_->TakeBack(group_.revisions());
  mesh_->Settle();
  const Head head = store_->head();
  if (mesh_->revision() != head.revision || mesh_->hash() != head.hash) {
    Lose(absl::StrCat("taken back to revision ", head.revision, " it has the hash ",
                      mesh_->hash().ToHex(), ", not ", head.hash.ToHex()))
        .IgnoreError();
  }
  for (HeldEdit& edit : group_.Take()) {
    if (edit.judged) edit.outcome = why;
    if (edit.job->stop != nullptr && !edit.outcome.ok()) edit.job->stop->store(true);
    Finish(std::move(edit));
  }
}

// Called while a batch runs longer than expected, so that the batches before it do not wait for its
// end. The mesh is in the middle of that batch and cannot undo: if the write fails, the group goes
// on waiting.
void MeshHost::RelieveGroup() {
  if (group_.empty() || MetricsClock::now() - group_since_ < turn_.time) return;
  if (WriteDown(group_.Unwritten(), group_.front().job->source).ok()) PublishGroup();
}

}  // namespace dynmesh::server
