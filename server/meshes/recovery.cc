#include "server/meshes/recovery.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/mesh_data/feature_set.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

// Applies the journal's data in its order: requests, parts of the snapshot, entries.
class Replay {
 public:
  Replay(RecoveredMesh& out, const MeshHost::Options& options, const std::function<void()>& applied)
      : out_(out), options_(options), applied_(applied), dimension_(out.made.options.dimension) {
    out_.past.requests.emplace(options.remembered_requests);
  }
  // Gives up when it returns true.
  void StopIf(const std::function<bool()>& interrupted) { apply_.interrupted = interrupted; }

  absl::Status Remember(const Journal::Request& request) {
    const auto answer = DecodeAnswer(request);
    if (!answer.ok()) return answer.status();
    out_.past.requests->Remember(request.id, *answer);
    return absl::OkStatus();
  }

  absl::Status AddPart(std::uint64_t revision, const std::string& part) {
    start_revision_ = revision;
    has_snapshot_ = true;
    sizes_.snapshot += part.size();
    return codec::DecodeJournalSnapshot(part, dimension_, &start_);
  }

  absl::Status Apply(const Journal::Entry& entry) {
    auto batch = codec::DecodeJournalEntry(entry.data, dimension_);
    if (!batch.ok()) return At(entry.revision, batch.status());
    if (start_revision_ == 0) start_.bits = batch->bits;
    if (!has_begun() && start_.bits != kMeshBits) return Gather(entry, *batch);
    if (absl::Status s = Begin(); !s.ok()) return s;
    absl::StatusOr<MeshDiff> diff = out_.mesh->Apply(batch->edits, apply_);
    if (!diff.ok()) return At(entry.revision, diff.status());
    if (diff->hash != batch->hash) return OtherHash(entry.revision, batch->hash);
    sizes_.Add(entry.revision, entry.data.size(), diff->work);
    ++out_.entries;
    applied_();
    RevisionStore& store = *out_.past.store;
    absl::Status status = store.Append(std::make_shared<const MeshDiff>(*std::move(diff)));
    // There are no readers yet that would rebase it.
    if (status.ok() && store.wants_rebase()) status = store.Latest().status();
    return status;
  }

  // Makes the mesh before the first entry that is applied by itself, or the whole mesh if there is
  // no such entry.
  absl::Status Begin() {
    if (has_begun()) return absl::OkStatus();
    if (start_revision_ > 0) {
      if (gathered_.size() > 0) start_.edits = mesh_data::EditsBetween({}, gathered_.Sorted());
      if (absl::Status s = out_.mesh->Apply(start_.edits, apply_).status(); !s.ok()) {
        return At(start_revision_, s);
      }
      has_other_bits_ = start_.bits != kMeshBits;
      if (!has_other_bits_ && out_.mesh->hash() != start_.hash) {
        return OtherHash(start_revision_, start_.hash);
      }
      out_.mesh->ResumeAt(start_revision_ + (has_other_bits_ ? 1 : 0));
      EditBatch().swap(start_.edits);
      gathered_ = {};
      if (has_snapshot_) applied_();
    }
    out_.past.store = std::make_shared<RevisionStore>(
        std::make_shared<const Mesh>(out_.mesh->Snapshot()), options_.history);
    return absl::OkStatus();
  }

  // After Begin: all that was read has other bits than this program's.
  bool has_other_bits() const { return has_other_bits_; }
  std::uint32_t bits() const { return start_.bits; }
  std::uint64_t snapshot_revision() const { return has_snapshot_ ? start_revision_ : 0; }
  const MeshLog::Sizes& sizes() const { return sizes_; }

 private:
  bool has_begun() const { return out_.past.store != nullptr; }

  // Joins an entry of other bits to the start. All entries up to here had other bits.
  absl::Status Gather(const Journal::Entry& entry, codec::JournalEntry& batch) {
    absl::Status status = gathered_.Apply(std::exchange(start_.edits, {}));
    if (status.ok()) status = gathered_.Apply(batch.edits);
    if (!status.ok()) return At(entry.revision, status);
    start_revision_ = entry.revision;
    start_.hash = batch.hash;
    start_.bits = batch.bits;
    sizes_.Add(entry.revision, entry.data.size(), {});
    applied_();
    return absl::OkStatus();
  }
  static absl::Status At(std::uint64_t revision, const absl::Status& status) {
    if (absl::IsCancelled(status)) return status;
    return absl::DataLossError(absl::StrCat(
        "revision ", revision, " cannot be recovered from the journal: ", status.message()));
  }
  absl::Status OtherHash(std::uint64_t revision, const MeshHash& expected) const {
    return absl::DataLossError(absl::StrCat("revision ", revision, " recovered has the hash ",
                                            out_.mesh->hash().ToHex(), ", not ", expected.ToHex()));
  }

  RecoveredMesh& out_;
  const MeshHost::Options& options_;
  const std::function<void()>& applied_;
  const int dimension_;
  ApplyOptions apply_;
  // Made in one batch: the snapshot and the gathered entries.
  std::uint64_t start_revision_ = 0;
  codec::JournalEntry start_;
  mesh_data::FeatureSet gathered_;
  bool has_snapshot_ = false;
  bool has_other_bits_ = false;
  MeshLog::Sizes sizes_;
};

absl::StatusOr<RecoveredMesh> Read(Journal& journal, const Journal::Mesh& found,
                                   const MeshFactory& factory, const MeshHost::Options& options,
                                   const std::function<void()>& applied, bool claims) {
  if (!found.damage.ok()) return found.damage;
  if (claims) {
    if (absl::Status s = journal.Claim(found.key); !s.ok()) return s;
  }
  RecoveredMesh recovered;
  auto made = codec::DecodeJournalMesh(found.description);
  if (!made.ok()) return made.status();
  recovered.made = *std::move(made);
  auto mesh = factory(recovered.made.options, {});
  if (!mesh.ok()) return mesh.status();
  recovered.mesh = *std::move(mesh);
  recovered.past.empty = recovered.mesh->hash();

  Replay replay(recovered, options, applied);
  Journal::Visitor visitor;
  visitor.request = [&](const Journal::Request& r) { return replay.Remember(r); };
  visitor.snapshot = [&](std::uint64_t r, const std::string& p) { return replay.AddPart(r, p); };
  visitor.entry = [&](const Journal::Entry& e) { return replay.Apply(e); };
  if (absl::Status s = journal.Read(found.key, visitor); !s.ok()) return s;
  if (absl::Status s = replay.Begin(); !s.ok()) return s;
  recovered.past.log =
      std::make_unique<MeshLog>(&journal, found.key, found.id, recovered.made.options.dimension,
                                replay.sizes(), options.compact);
  if (!claims) {
    if (!replay.has_other_bits()) {
      recovered.past.follows = replay.snapshot_revision();
      return recovered;
    }
    return absl::UnimplementedError(
        absl::StrCat("the journal has the bits ", replay.bits(), ", this server ", kMeshBits));
  }
  if (!replay.has_other_bits()) return recovered;
  if (found.loss.ok()) {
    recovered.past.log->writer().AssertHeld();  // no other thread has it yet
    if (absl::Status s = recovered.past.log->AppendOtherBits(*recovered.mesh); !s.ok()) return s;
  }
  Log(LogLevel::kInfo, "bits_changed",
      {{"mesh", found.id},
       {"revision", recovered.mesh->revision()},
       {"from", replay.bits()},
       {"to", kMeshBits}});
  return recovered;
}

}  // namespace

absl::StatusOr<RecoveredMesh> RecoverMesh(Journal& journal, const Journal::Mesh& found,
                                          const MeshFactory& factory,
                                          const MeshHost::Options& options,
                                          const std::function<void()>& applied) {
  return Read(journal, found, factory, options, applied, /*claims=*/true);
}

absl::StatusOr<RecoveredMesh> ReadMesh(Journal& journal, const Journal::Mesh& found,
                                       const MeshFactory& factory,
                                       const MeshHost::Options& options) {
  return Read(
      journal, found, factory, options, [] {}, /*claims=*/false);
}

absl::StatusOr<std::shared_ptr<RevisionStore>> ReadPast(Journal& journal, Journal::Key mesh,
                                                        const MeshOptions& made_with,
                                                        const MeshFactory& factory,
                                                        const MeshHost::Options& options,
                                                        std::uint64_t from, std::uint64_t to,
                                                        const std::function<bool()>& interrupted) {
  RecoveredMesh past;
  past.made.options = made_with;
  auto made = factory(made_with, {.interrupted = interrupted});
  if (!made.ok()) return made.status();
  past.mesh = *std::move(made);
  const std::function<void()> applied = [] {};
  Replay replay(past, options, applied);
  replay.StopIf(interrupted);
  Journal::Visitor visitor;
  visitor.snapshot = [&](std::uint64_t r, const std::string& p) { return replay.AddPart(r, p); };
  visitor.entry = [&](const Journal::Entry& e) { return replay.Apply(e); };
  absl::Status status = journal.ReadPast(mesh, from, to, visitor);
  if (status.ok()) status = replay.Begin();
  if (!status.ok()) return status;
  if (replay.has_other_bits() || past.past.store->oldest() > from) {
    return absl::UnimplementedError("the journal has other bits than this server");
  }
  return past.past.store;
}

absl::StatusOr<RequestMemory::Entry> DecodeAnswer(const Journal::Request& request) {
  const auto answer = codec::DecodeJournalAnswer(request.answer);
  if (!answer.ok()) return answer.status();
  return RequestMemory::Entry{{answer->content_a, answer->content_b},
                              answer->from_revision,
                              answer->to_revision,
                              answer->hash,
                              answer->work};
}

}  // namespace dynmesh::server
