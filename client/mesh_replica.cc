#include "client/mesh_replica.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/v1/mesh_service.pb.h"

namespace dynmesh::client {
namespace {

absl::Status Gap(const std::string& what) {
  return absl::FailedPreconditionError(absl::StrCat(what, ": watch anew, from a snapshot"));
}

}  // namespace

absl::StatusOr<MeshReplica::Change> MeshReplica::Take(const v1::WatchEvent& event) {
  absl::StatusOr<Change> change = Change();
  switch (event.event_case()) {
    case v1::WatchEvent::kSnapshot:
      change = TakeSnapshot(event.snapshot());
      break;
    case v1::WatchEvent::kDiff:
      change = TakeDiff(event.diff());
      break;
    case v1::WatchEvent::kProgress:
      change = TakeProgress(event.progress().revision(), event.progress().hash());
      break;
    case v1::WatchEvent::EVENT_NOT_SET:
      return change;  // from a newer server: nothing that concerns the mesh
  }
  if (!change.ok()) {
    state_ = State::kBroken;
    EndOfStream();
  }
  return change;
}

void MeshReplica::EndOfStream() {
  snapshot_.Reset();
  diff_.Reset();
}

absl::StatusOr<MeshReplica::Change> MeshReplica::TakeSnapshot(const v1::SnapshotChunk& chunk) {
  if (!diff_.empty()) return Gap("a snapshot begins inside a diff");
  absl::StatusOr<std::optional<Mesh>> mesh = snapshot_.Add(chunk);
  if (!mesh.ok()) return mesh.status();
  if (!mesh->has_value()) return Change();
  absl::StatusOr<data::MeshStore> store = data::MeshStore::FromMesh(**mesh);
  if (!store.ok()) return absl::DataLossError(store.status().message());
  store_ = *std::move(store);
  state_ = State::kLive;
  has_mesh_ = true;
  return Change(NewSnapshot());
}

absl::StatusOr<MeshReplica::Change> MeshReplica::TakeDiff(const v1::MeshDiff& fragment) {
  if (state_ != State::kLive) return Gap("a diff came without a mesh to change");
  if (!snapshot_.empty()) return Gap("a diff came inside a snapshot");
  // Said before the rest is waited for.
  if (fragment.from_revision() != store_.revision() ||
      fragment.to_revision() <= fragment.from_revision()) {
    return Gap(absl::StrCat("a diff from revision ", fragment.from_revision(), " to ",
                            fragment.to_revision(), " does not continue revision ",
                            store_.revision()));
  }
  if (fragment.columns_omitted()) return Gap("a diff came without its columns");
  absl::StatusOr<std::optional<MeshDiff>> diff = diff_.Add(fragment);
  if (!diff.ok()) return diff.status();
  if (!diff->has_value()) return Change();
  if (absl::Status status = store_.Apply(**diff); !status.ok()) {
    return absl::DataLossError(status.message());
  }
  return Change(**std::move(diff));
}

absl::StatusOr<MeshReplica::Change> MeshReplica::TakeProgress(std::uint64_t revision,
                                                              const std::string& hash) const {
  if (state_ != State::kLive) return Gap("progress came without a mesh");
  if (!diff_.empty() || !snapshot_.empty()) return Gap("progress came inside a revision");
  if (revision != store_.revision()) {
    return Gap(absl::StrCat("the server sent all up to revision ", revision,
                            ", but the replica is at ", store_.revision()));
  }
  if (hash != store_.hash().ToHex()) {
    return absl::DataLossError(absl::StrCat("at revision ", revision, " the server has hash ", hash,
                                            ", the replica ", store_.hash().ToHex()));
  }
  return Change(Progress());
}

}  // namespace dynmesh::client
