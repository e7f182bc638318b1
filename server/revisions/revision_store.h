// The history of one mesh for its readers: a whole snapshot at some revision, and diffs before and
// after it.
//
//   oldest ........ base ............ head
//          diffs kept     diffs since
//
// Invariants:
//   1. oldest() <= base()->revision <= head().revision;
//   2. every diff from oldest to head is held, in order, without a gap;
//   3. returned objects never change.
// An edit costs the writer O(1) here. A reader that wants the present mesh applies the diffs to the
// base on its own thread, and the result is the next base. wants_rebase() requests such a read when
// the diffs since the base outweigh it, or three of four of its simplices are removed. So memory is
// bounded by a multiple of the mesh, at amortised O(1) per row of a diff. Thread-safe: one writer
// (Append), any number of readers.
#ifndef DYNMESH_SERVER_REVISIONS_REVISION_STORE_H_
#define DYNMESH_SERVER_REVISIONS_REVISION_STORE_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "dynmesh/mesh.h"

namespace dynmesh::server {

struct Head {
  std::uint64_t revision = 0;
  MeshHash hash;
};

class RevisionStore {
 public:
  using DiffPtr = std::shared_ptr<const MeshDiff>;
  using MeshPtr = std::shared_ptr<const Mesh>;

  // Bounds the diffs before the base: the oldest are dropped first. The newest diff is always kept.
  struct Limits {
    std::size_t revisions = 10'000;
    std::size_t bytes = 64 << 20;
  };

  RevisionStore(MeshPtr base, Limits limits);

  // FAILED_PRECONDITION, without an effect, unless the diff leads from the head to the next
  // revision.
  absl::Status Append(DiffPtr diff);

  Head head() const;
  std::uint64_t oldest() const;
  MeshPtr base() const;
  bool wants_rebase() const;

  // The mesh's hash at a revision in [oldest, head].
  std::optional<MeshHash> HashAt(std::uint64_t revision) const;
  // The diff from `revision` to the next; null if it is not held.
  DiffPtr DiffFrom(std::uint64_t revision) const;
  // All diffs from `revision` to the head: empty at the head, nullopt if not all are held.
  std::optional<std::vector<DiffPtr>> DiffsFrom(std::uint64_t revision) const;

  // The mesh at the head. O(mesh) if edits came since the last call. Calls wait for each other but
  // never for the writer.
  absl::StatusOr<MeshPtr> Latest();

 private:
  void TrimLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Limits limits_;
  Mutex latest_mutex_;  // held while diffs are applied to the base; acquired first
  mutable Mutex mutex_;
  MeshPtr base_ ABSL_GUARDED_BY(mutex_);
  std::size_t base_bytes_ ABSL_GUARDED_BY(mutex_);
  std::size_t base_simplices_ ABSL_GUARDED_BY(mutex_), head_simplices_ ABSL_GUARDED_BY(mutex_);
  MeshHash oldest_hash_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t oldest_ ABSL_GUARDED_BY(mutex_);
  Head head_ ABSL_GUARDED_BY(mutex_);
  std::deque<DiffPtr> diffs_ ABSL_GUARDED_BY(mutex_);  // diffs_[i] leads from revision oldest_ + i
  std::size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;      // of all diffs held
  std::size_t bytes_since_base_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_REVISIONS_REVISION_STORE_H_
