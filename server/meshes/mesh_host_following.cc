// The part of MeshHost that follows the journal of a mesh that another server has, and that takes
// or gives the mesh.
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/journal_codec.h"
#include "server/base/log.h"
#include "server/meshes/mesh_host.h"
#include "server/meshes/recovery.h"

namespace dynmesh::server {

void MeshHost::Follow(SharedJournal::Tail tail, std::function<void(absl::Status)> done) {
  auto shared = std::make_shared<const SharedJournal::Tail>(std::move(tail));
  strand_->Post([self = shared_from_this(), shared, done = std::move(done)] {
    self->writer_->strand().AssertHeld();
    done(self->TakeTail(*shared));
  });
}

absl::Status MeshHost::TakeTail(const SharedJournal::Tail& tail) {
  if (absl::Status s = readers_->closed(); !s.ok()) return absl::CancelledError(s.message());
  if (seen_snapshot_ < tail.snapshot) writer_->log()->SawSnapshot(tail.snapshot_bytes);
  seen_snapshot_ = tail.snapshot;
  absl::Status status;
  for (auto entry = tail.entries.begin(); status.ok() && entry != tail.entries.end(); ++entry) {
    status = TakeEntry(*entry);
  }
  for (auto it = tail.requests.begin(); status.ok() && it != tail.requests.end(); ++it) {
    status = Remember(*it);
  }
  readers_->Notify();
  readers_->TellWaiters();
  return status;
}

absl::Status MeshHost::TakeEntry(const Journal::Entry& entry) {
  const auto at = [&entry](absl::string_view what) {
    return absl::DataLossError(absl::StrCat("revision ", entry.revision, " ", what));
  };
  const auto batch = codec::DecodeJournalEntry(entry.data, mesh_options_.dimension);
  if (!batch.ok()) return at(batch.status().message());
  if (batch->bits != kMeshBits) {
    return absl::UnimplementedError(absl::StrCat("revision ", entry.revision, " has the bits ",
                                                 batch->bits, ", those of this server are ",
                                                 kMeshBits));
  }
  ApplyOptions options;
  options.interrupted = [this] { return readers_->ended(); };
  absl::StatusOr<MeshDiff> diff = mesh_->Apply(batch->edits, options);
  if (!diff.ok()) {
    return readers_->ended() ? diff.status()
                             : at(absl::StrCat("cannot be applied: ", diff.status().message()));
  }
  if (diff->to_revision != entry.revision) {
    return at(absl::StrCat("makes revision ", diff->to_revision));
  }
  if (diff->hash != batch->hash) {
    return at(absl::StrCat("has the hash ", diff->hash.ToHex(), " here, and ", batch->hash.ToHex(),
                           " in the journal"));
  }
  writer_->log()->SawEntry(entry.revision, entry.data.size(), diff->work);
  const absl::Status published =
      readers_->Append(std::make_shared<const MeshDiff>(*std::move(diff)), mesh_->Stats());
  return published.ok() ? published : at(published.message());
}

absl::Status MeshHost::Remember(const Journal::Request& request) {
  if (writer_->FindAnswered(request.id) != nullptr) return absl::OkStatus();
  const auto answer = DecodeAnswer(request);
  if (!answer.ok()) return answer.status();
  writer_->Remember(request.id, *answer);
  return absl::OkStatus();
}

void MeshHost::HandOver(std::function<absl::StatusOr<MeshOwner>()> give,
                        std::function<void(absl::Status)> done) {
  strand_->Post([self = shared_from_this(), give = std::move(give), done = std::move(done)] {
    self->writer_->strand().AssertHeld();
    if (!self->writer_->IsWritten()) return;
    if (absl::Status s = self->readers_->closed(); !s.ok()) return done(s);
    const absl::StatusOr<MeshOwner> owner = give();
    if (owner.ok()) {
      self->writer_->GiveUp(NotOwnerError(self->id_, *owner));
      Log(LogLevel::kInfo, "mesh_handed_over",
          {{"mesh", self->id_},
           {"revision", self->head().revision},
           {"owner", owner->address},
           {"epoch", owner->epoch}});
    }
    done(owner.status());
  });
}

}  // namespace dynmesh::server
