#include "dynmesh/client/mesh_replica.h"

#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::client {
namespace {

absl::Status Gap(const std::string& what) {
  return absl::FailedPreconditionError(absl::StrCat(what, ": start a new watch, with a snapshot"));
}

}  // namespace

struct MeshReplica::Impl {
  absl::StatusOr<Change> Take(const v1::WatchEvent& event);
  absl::StatusOr<Change> TakeSnapshot(const v1::SnapshotChunk& chunk);
  absl::StatusOr<Change> TakeDiff(const v1::MeshDiff& fragment);
  absl::StatusOr<Change> TakeProgress(std::uint64_t revision, const std::string& hash) const;
  void EndOfStream();

  State state = State::kEmpty;
  bool has_mesh = false;
  SlotMesh store;
  codec::SnapshotAssembler snapshot;
  codec::DiffAssembler diff;
};

absl::StatusOr<MeshReplica::Change> MeshReplica::Impl::Take(const v1::WatchEvent& event) {
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
      return change;  // from a newer server: does not change the mesh
  }
  if (!change.ok()) {
    state = State::kBroken;
    EndOfStream();
  }
  return change;
}

void MeshReplica::Impl::EndOfStream() {
  snapshot.Reset();
  diff.Reset();
}

absl::StatusOr<MeshReplica::Change> MeshReplica::Impl::TakeSnapshot(
    const v1::SnapshotChunk& chunk) {
  if (!diff.empty()) return Gap("a snapshot begins inside a diff");
  absl::StatusOr<std::optional<Mesh>> mesh = snapshot.Add(chunk);
  if (!mesh.ok()) return mesh.status();
  if (!mesh->has_value()) return Change();
  absl::StatusOr<SlotMesh> whole = SlotMesh::FromMesh(**mesh);
  if (!whole.ok()) return absl::DataLossError(whole.status().message());
  store = *std::move(whole);
  state = State::kLive;
  has_mesh = true;
  return Change(NewSnapshot());
}

absl::StatusOr<MeshReplica::Change> MeshReplica::Impl::TakeDiff(const v1::MeshDiff& fragment) {
  if (state != State::kLive) return Gap("a diff came without a mesh to change");
  if (!snapshot.empty()) return Gap("a diff came inside a snapshot");
  // Reported before the remaining fragments are received.
  if (fragment.from_revision() != store.revision() ||
      fragment.to_revision() <= fragment.from_revision()) {
    return Gap(absl::StrCat("a diff from revision ", fragment.from_revision(), " to ",
                            fragment.to_revision(), " does not continue revision ",
                            store.revision()));
  }
  if (fragment.columns_omitted()) return Gap("a diff came without its columns");
  absl::StatusOr<std::optional<MeshDiff>> whole = diff.Add(fragment);
  if (!whole.ok()) return whole.status();
  if (!whole->has_value()) return Change();
  if (absl::Status status = store.Apply(**whole); !status.ok()) {
    return absl::DataLossError(status.message());
  }
  return Change(**std::move(whole));
}

absl::StatusOr<MeshReplica::Change> MeshReplica::Impl::TakeProgress(std::uint64_t revision,
                                                                    const std::string& hash) const {
  if (state != State::kLive) return Gap("progress came without a mesh");
  if (!diff.empty() || !snapshot.empty()) return Gap("progress came inside a revision");
  if (revision != store.revision()) {
    return Gap(absl::StrCat("the server sent all up to revision ", revision,
                            ", but the replica is at ", store.revision()));
  }
  if (hash != store.hash().ToHex()) {
    return absl::DataLossError(absl::StrCat("at revision ", revision, " the server has hash ", hash,
                                            ", the replica ", store.hash().ToHex()));
  }
  return Change(Progress());
}

MeshReplica::MeshReplica() : impl_(std::make_unique<Impl>()) {}
MeshReplica::MeshReplica(MeshReplica&& other) noexcept = default;
MeshReplica& MeshReplica::operator=(MeshReplica&& other) noexcept = default;
MeshReplica::~MeshReplica() = default;

absl::StatusOr<MeshReplica::Change> MeshReplica::Take(const v1::WatchEvent& event) {
  return impl_->Take(event);
}
void MeshReplica::EndOfStream() { impl_->EndOfStream(); }

MeshReplica::State MeshReplica::state() const { return impl_->state; }
bool MeshReplica::has_mesh() const { return impl_->has_mesh; }
std::uint64_t MeshReplica::revision() const { return impl_->store.revision(); }
MeshHash MeshReplica::hash() const { return impl_->store.hash(); }
int MeshReplica::dimension() const { return impl_->store.dimension(); }
std::size_t MeshReplica::vertex_count() const { return impl_->store.vertex_count(); }
std::size_t MeshReplica::simplex_count() const { return impl_->store.simplex_count(); }
std::size_t MeshReplica::subsegment_count() const { return impl_->store.subsegment_count(); }
std::size_t MeshReplica::subfacet_count() const { return impl_->store.subfacet_count(); }
const SlotMesh& MeshReplica::mesh() const { return impl_->store; }
Mesh MeshReplica::ToMesh() const { return impl_->store.ToMesh(); }

}  // namespace dynmesh::client
