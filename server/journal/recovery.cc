#include "server/journal/recovery.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

// Takes what the journal tells, in its order: requests, parts of the snapshot, entries.
class Replay {
 public:
  Replay(RecoveredMesh& out, const MeshHost::Options& options, const std::function<void()>& applied)
      : out_(out), options_(options), applied_(applied), dimension_(out.made.options.dimension) {
    out_.past.requests.emplace(options.remembered_requests);
  }

  absl::Status Remember(const Journal::Request& request) {
    const auto answer = codec::DecodeJournalAnswer(request.answer);
    if (!answer.ok()) return answer.status();
    out_.past.requests->Remember(request.id, {{answer->content_a, answer->content_b},
                                              answer->from_revision,
                                              answer->to_revision,
                                              answer->hash,
                                              answer->work});
    return absl::OkStatus();
  }

  absl::Status AddPart(std::uint64_t revision, const std::string& part) {
    snapshot_revision_ = revision;
    sizes_.snapshot += part.size();
    return codec::DecodeJournalSnapshot(part, dimension_, &snapshot_);
  }

  absl::Status Apply(const Journal::Entry& entry) {
    if (absl::Status s = Begin(); !s.ok()) return s;
    const auto batch = codec::DecodeJournalEntry(entry.data, dimension_);
    if (!batch.ok()) return At(entry.revision, batch.status());
    absl::StatusOr<MeshDiff> diff = out_.mesh->Apply(batch->edits);
    if (!diff.ok()) return At(entry.revision, diff.status());
    if (diff->hash != batch->hash) return OtherHash(entry.revision, batch->hash);
    sizes_.Add(entry.revision, entry.data.size(), diff->work);
    ++out_.entries;
    applied_();
    RevisionStore& store = *out_.past.store;
    absl::Status status = store.Append(std::make_shared<const MeshDiff>(*std::move(diff)));
    // Nobody reads yet who would ask for it.
    if (status.ok() && store.wants_rebase()) status = store.Latest().status();
    return status;
  }

  // What precedes the first entry, or was all there is.
  absl::Status Begin() {
    if (out_.past.store != nullptr) return absl::OkStatus();
    if (snapshot_revision_ > 0) {
      if (absl::Status s = out_.mesh->Apply(snapshot_.edits).status(); !s.ok()) {
        return At(snapshot_revision_, s);
      }
      if (out_.mesh->hash() != snapshot_.hash) {
        return OtherHash(snapshot_revision_, snapshot_.hash);
      }
      out_.mesh->ResumeAt(snapshot_revision_);
      EditBatch().swap(snapshot_.edits);
      applied_();
    }
    out_.past.store = std::make_shared<RevisionStore>(
        std::make_shared<const Mesh>(out_.mesh->Snapshot()), options_.history);
    return absl::OkStatus();
  }

  const MeshLog::Sizes& sizes() const { return sizes_; }

 private:
  static absl::Status At(std::uint64_t revision, const absl::Status& status) {
    return absl::DataLossError(absl::StrCat(
        "revision ", revision, " cannot be made again from the journal: ", status.message()));
  }
  absl::Status OtherHash(std::uint64_t revision, const MeshHash& expected) const {
    return absl::DataLossError(absl::StrCat("revision ", revision, " made again has the hash ",
                                            out_.mesh->hash().ToHex(), ", not ", expected.ToHex()));
  }

  RecoveredMesh& out_;
  const MeshHost::Options& options_;
  const std::function<void()>& applied_;
  const int dimension_;
  std::uint64_t snapshot_revision_ = 0;
  codec::JournalEntry snapshot_;
  MeshLog::Sizes sizes_;
};

}  // namespace

absl::StatusOr<RecoveredMesh> RecoverMesh(Journal& journal, const Journal::Mesh& found,
                                          const MeshFactory& factory,
                                          const MeshHost::Options& options,
                                          const std::function<void()>& applied) {
  if (!found.damage.ok()) return found.damage;
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
  return recovered;
}

}  // namespace dynmesh::server
