#include "server/revisions/revision_store.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/revisions/diff_algebra.h"

namespace dynmesh::server {
namespace {

// A small mesh is not rebased after every few edits.
constexpr std::size_t kLeastRebaseBytes = 1 << 20;

}  // namespace

RevisionStore::RevisionStore(MeshPtr base, Limits limits)
    : limits_(limits),
      base_(std::move(base)),
      base_bytes_(ByteSize(*base_)),
      base_simplices_(base_->simplex_count()),
      head_simplices_(base_simplices_),
      oldest_hash_(base_->hash),
      oldest_(base_->revision),
      head_{base_->revision, base_->hash} {}

absl::Status RevisionStore::Append(DiffPtr diff) {
  const std::size_t bytes = ByteSize(*diff);
  const MutexLock lock(mutex_);
  if (diff->from_revision != head_.revision || diff->to_revision != head_.revision + 1) {
    return absl::FailedPreconditionError(
        absl::StrCat("a diff from ", diff->from_revision, " to ", diff->to_revision,
                     " does not continue revision ", head_.revision));
  }
  head_ = {diff->to_revision, diff->hash};
  head_simplices_ += diff->added_simplex_count() - diff->removed_simplex_count();
  diffs_.push_back(std::move(diff));
  bytes_ += bytes;
  bytes_since_base_ += bytes;
  TrimLocked();
  return absl::OkStatus();
}

void RevisionStore::TrimLocked() {
  while (diffs_.size() > 1 && oldest_ < base_->revision &&
         (diffs_.size() > limits_.revisions || bytes_ > limits_.bytes)) {
    bytes_ -= ByteSize(*diffs_.front());
    oldest_hash_ = diffs_.front()->hash;
    diffs_.pop_front();
    ++oldest_;
  }
}

Head RevisionStore::head() const {
  const MutexLock lock(mutex_);
  return head_;
}

std::uint64_t RevisionStore::oldest() const {
  const MutexLock lock(mutex_);
  return oldest_;
}

RevisionStore::MeshPtr RevisionStore::base() const {
  const MutexLock lock(mutex_);
  return base_;
}

bool RevisionStore::wants_rebase() const {
  const MutexLock lock(mutex_);
  // Many small diffs count as well: Limits does not apply to the diffs since the base.
  const std::size_t since = head_.revision - base_->revision;
  return bytes_since_base_ > std::max(base_bytes_, kLeastRebaseBytes) ||
         since > limits_.revisions ||
         (base_bytes_ > kLeastRebaseBytes && head_simplices_ < base_simplices_ / 4);
}

std::optional<MeshHash> RevisionStore::HashAt(std::uint64_t revision) const {
  const MutexLock lock(mutex_);
  if (revision < oldest_ || revision > head_.revision) return std::nullopt;
  return revision == oldest_ ? oldest_hash_ : diffs_[revision - oldest_ - 1]->hash;
}

RevisionStore::DiffPtr RevisionStore::DiffFrom(std::uint64_t revision) const {
  const MutexLock lock(mutex_);
  if (revision < oldest_ || revision >= head_.revision) return nullptr;
  return diffs_[revision - oldest_];
}

std::optional<std::vector<RevisionStore::DiffPtr>> RevisionStore::DiffsFrom(
    std::uint64_t revision) const {
  const MutexLock lock(mutex_);
  if (revision < oldest_ || revision > head_.revision) return std::nullopt;
  return std::vector<DiffPtr>(diffs_.begin() + static_cast<std::ptrdiff_t>(revision - oldest_),
                              diffs_.end());
}

absl::StatusOr<RevisionStore::MeshPtr> RevisionStore::Latest() {
  const MutexLock latest_lock(latest_mutex_);
  MeshPtr mesh;
  std::vector<DiffPtr> diffs;
  {
    const MutexLock lock(mutex_);
    mesh = base_;
    if (mesh->revision == head_.revision) return mesh;
    diffs.assign(diffs_.begin() + static_cast<std::ptrdiff_t>(mesh->revision - oldest_),
                 diffs_.end());
  }
  absl::StatusOr<Mesh> patched =
      diffs.size() == 1 ? Patched(*mesh, *diffs.front()) : Patched(*mesh, Compose(diffs));
  if (!patched.ok()) return patched.status();
  mesh = std::make_shared<const Mesh>(*std::move(patched));
  const std::size_t mesh_bytes = ByteSize(*mesh);

  const MutexLock lock(mutex_);
  base_ = mesh;
  base_bytes_ = mesh_bytes;
  base_simplices_ = mesh->simplex_count();
  bytes_since_base_ = 0;
  for (std::uint64_t r = mesh->revision; r < head_.revision; ++r) {
    bytes_since_base_ += ByteSize(*diffs_[r - oldest_]);
  }
  TrimLocked();
  return mesh;
}

}  // namespace dynmesh::server
