// What one mesh writes into the journal: every batch before anybody sees what it did, those that
// are ready at once together, and now and then a snapshot of its features, from which the mesh is
// made again then.
//
// A snapshot is due when the batches since the last one outweigh it, in bytes or in the work of
// doing them again, and some least weight: amortised O(1) for each byte and each operation of a
// batch. So a generation (journal.h) has at most twice the features' bytes, and a mesh is made
// again in at most three times what making it from its features takes, or those least weights. The
// first batch, often a whole load, is as good as a snapshot: none is made of the same again.
// Calls block. Thread-compatible: it belongs to the mesh's strand.
#ifndef DYNMESH_SERVER_JOURNAL_MESH_LOG_H_
#define DYNMESH_SERVER_JOURNAL_MESH_LOG_H_

#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/journal/journal.h"
#include "server/journal/mesh_history.h"
#include "server/revisions/request_memory.h"

namespace dynmesh::server {

class MeshLog {
 public:
  // What the generation weighs.
  struct Sizes {
    std::uint64_t snapshot = 0;    // bytes of the snapshot, or of the first batch
    std::uint64_t entries = 0;     // bytes of the batches since
    std::uint64_t operations = 0;  // that these executed

    void Add(std::uint64_t revision, std::uint64_t bytes, const WorkCounters& work) {
      if (revision == 1) {
        snapshot += bytes;
      } else {
        entries += bytes;
        operations += work.executed;
      }
    }
  };
  // No snapshot for less since the last one.
  struct Limits {
    std::uint64_t bytes = 1 << 20;
    std::uint64_t operations = 1'000'000;  // some seconds to do again
  };

  MeshLog(Journal* journal, Journal::Key key, std::string id, int dimension, const Sizes& sizes,
          const Limits& limits);

  // A batch, and its answer, which is kept if there is a request_id.
  struct Batch {
    const EditBatch* edits = nullptr;
    absl::string_view request_id;
    RequestMemory::Entry answer;
  };
  // Returns when all of them are durable; not OK: none is. In the order of their revisions. Errors
  // as JournalError.
  absl::Status Append(std::span<const Batch> batches);

  // What it writes, to be read. `empty`: as MeshHistory's.
  MeshHistory History(const MeshHash& empty) const {
    return MeshHistory(journal_, key_, id_, dimension_, empty);
  }

  // The mesh's last revision has the features of the one before, and other bits (kMeshBits): writes
  // it down, and a snapshot. Errors as Append; a snapshot that fails is logged.
  absl::Status AppendOtherBits(const DynamicMesh& mesh);

  // After a batch; O(1) but for when it is due. What fails is logged, and tried again later.
  void CompactIfDue(const DynamicMesh& mesh);

 private:
  bool IsDue(const DynamicMesh& mesh) const;
  void Compact(const DynamicMesh& mesh);

  Journal* const journal_;
  const Journal::Key key_;
  const std::string id_;
  const int dimension_;
  const Limits limits_;
  Sizes sizes_;
  std::uint64_t failed_at_ = 0;  // bytes of entries when a snapshot failed, since the last one
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_MESH_LOG_H_
