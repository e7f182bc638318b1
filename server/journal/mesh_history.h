// The features of one mesh at its revisions, as far back as the journal goes: those of a snapshot,
// changed by the batches since. Immutable and thread-safe; reads a consistent state and waits for
// no writer. O(features + edits since the snapshot) in time and memory.
#ifndef DYNMESH_SERVER_JOURNAL_MESH_HISTORY_H_
#define DYNMESH_SERVER_JOURNAL_MESH_HISTORY_H_

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/codec/features_at.h"
#include "dynmesh/mesh.h"
#include "server/journal/journal.h"
#include "server/revisions/revision_store.h"

namespace dynmesh::server {

using codec::FeaturesAt;

class MeshHistory {
 public:
  // `empty`: the hash of the mesh without features. The journal outlives this object.
  MeshHistory(Journal* journal, Journal::Key key, std::string id, int dimension,
              const MeshHash& empty)
      : journal_(journal), key_(key), id_(std::move(id)), dimension_(dimension), empty_(empty) {}

  // OUT_OF_RANGE (COMPACTED, with the oldest revision in the metadata; FUTURE_REVISION if
  // `revision` is after `head`, the mesh's), NOT_FOUND (MESH_DELETED), DATA_LOSS or UNAVAILABLE
  // (JOURNAL_FAILED), CANCELLED soon after `cancelled`, which may be null, turned true.
  absl::StatusOr<FeaturesAt> At(std::uint64_t revision, const Head& head,
                                const std::atomic<bool>* cancelled) const;

  // Two revisions at the cost of one; the first is not later than the second.
  struct Span {
    FeaturesAt from, to;
    std::uint32_t from_bits = kMeshBits;  // the bits of from.hash
  };
  absl::StatusOr<Span> Between(std::uint64_t from, std::uint64_t to, const Head& head,
                               const std::atomic<bool>* cancelled) const;

  // What it reads.
  Journal& journal() const { return *journal_; }
  Journal::Key key() const { return key_; }

 private:
  absl::Status ErrorOf(const absl::Status& status, std::uint64_t revision, const Head& head) const;

  Journal* const journal_;
  const Journal::Key key_;
  const std::string id_;
  const int dimension_;
  const MeshHash empty_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_MESH_HISTORY_H_
