// What one mesh writes into the journal: every batch before it comes into effect, and now and then
// a snapshot of its features, from which the mesh is made again then.
//
// A snapshot is due when the batches since the last one outweigh it (and some least size):
// amortised O(1) for each byte of a batch. A generation (journal.h) has at most twice the features'
// bytes, or that size. Calls
// block. Thread-compatible: it belongs to the mesh's strand.
#ifndef DYNMESH_SERVER_JOURNAL_MESH_LOG_H_
#define DYNMESH_SERVER_JOURNAL_MESH_LOG_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/journal/journal.h"
#include "server/journal/mesh_history.h"
#include "server/meshes/request_memory.h"

namespace dynmesh::server {

class MeshLog {
 public:
  // Bytes in the journal.
  struct Sizes {
    std::uint64_t snapshot = 0;
    std::uint64_t entries = 0;
  };

  MeshLog(Journal* journal, Journal::Key key, std::string id, int dimension, const Sizes& sizes,
          std::uint64_t compact_bytes);

  // Returns when batch and answer (the latter if there is a request_id) are durable. Errors as
  // JournalError.
  absl::Status Append(const EditBatch& edits, const std::string& request_id,
                      const RequestMemory::Entry& answer);

  // What it writes, to be read. `empty`: as MeshHistory's.
  MeshHistory History(const MeshHash& empty) const {
    return MeshHistory(journal_, key_, id_, dimension_, empty);
  }

  // After a batch; O(1) but for when it is due. What fails is logged, and tried again later.
  void CompactIfDue(const DynamicMesh& mesh);

 private:
  Journal* const journal_;
  const Journal::Key key_;
  const std::string id_;
  const int dimension_;
  const std::uint64_t compact_bytes_;
  Sizes sizes_;
  std::uint64_t due_at_;  // bytes of entries
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_MESH_LOG_H_
