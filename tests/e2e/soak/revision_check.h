// The guarantees for a watcher, checked without a mesh: every revision once, in order, fragments
// and chunks complete, and consistent hashes. A model of MeshReplica without rows, so that a
// hundred of them cost nothing.
//
// Thread-compatible. An event costs O(1).
#ifndef DYNMESH_TESTS_E2E_SOAK_REVISION_CHECK_H_
#define DYNMESH_TESTS_E2E_SOAK_REVISION_CHECK_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/v1/mesh_service.pb.h"

namespace dynmesh::soak {

class RevisionCheck {
 public:
  enum class Step {
    kPart,       // more of the same is to come
    kSnapshot,   // a whole mesh
    kRevision,   // the next revision
    kCoalesced,  // several revisions in one
    kProgress,
  };

  // OUT_OF_RANGE if a revision was lost, ALREADY_EXISTS if one came twice or revisions went back,
  // DATA_LOSS if the parts do not fit together.
  absl::StatusOr<Step> Take(const v1::WatchEvent& event);

  // The stream ended: incomplete parts do not count.
  void EndOfStream();
  // As new: the next event has to be a snapshot.
  void Forget() { *this = RevisionCheck(); }

  // The last whole revision; none before the first.
  std::optional<std::uint64_t> revision() const { return revision_; }
  // The server's, at that revision.
  const std::string& hash() const { return hash_; }

 private:
  absl::StatusOr<Step> TakeSnapshot(const v1::SnapshotChunk& chunk);
  absl::StatusOr<Step> TakeDiff(const v1::MeshDiff& fragment);
  absl::StatusOr<Step> TakeProgress(const v1::Progress& progress) const;

  std::optional<std::uint64_t> revision_;
  std::string hash_;
  std::optional<v1::SnapshotChunk> chunk_;  // the last one of a snapshot that goes on, bare
  std::optional<std::uint64_t> diff_to_;    // of a diff that goes on
};

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_REVISION_CHECK_H_
