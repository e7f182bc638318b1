// Writes one mesh to the journal: every batch before its effects become visible, batches that are
// ready together in one write, and now and then a snapshot of its features, from which the mesh is
// recovered.
//
// A snapshot is due when the batches since the last one exceed a minimum and outweigh it, in bytes
// or in the work to replay them: amortised O(1) for each byte and each operation of a batch. So,
// above those minimums, a generation (journal.h) has at most twice the features' bytes, and
// recovery takes at most three times as long as making the mesh from its features. The first batch,
// often a whole load, serves as a snapshot. Calls block. Thread-compatible: the mesh's strand makes
// one call at a time, or has another thread make it.
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
  // Sizes of the generation.
  struct Sizes {
    std::uint64_t snapshot = 0;    // bytes of the snapshot, or of the first batch
    std::uint64_t entries = 0;     // bytes of the batches since
    std::uint64_t operations = 0;  // operations executed by these

    void Add(std::uint64_t revision, std::uint64_t bytes, const WorkCounters& work) {
      if (revision == 1) {
        snapshot += bytes;
      } else {
        entries += bytes;
        operations += work.executed;
      }
    }
  };
  // Minimums since the last snapshot for the next one.
  struct Limits {
    std::uint64_t bytes = 1 << 20;
    std::uint64_t operations = 1'000'000;  // some seconds to replay
  };

  MeshLog(Journal* journal, Journal::Key key, std::string id, int dimension, const Sizes& sizes,
          const Limits& limits);

  // A batch, and its answer, which is kept if there is a request_id.
  struct Batch {
    const EditBatch* edits = nullptr;
    absl::string_view request_id;
    RequestMemory::Entry answer;
  };
  // Returns when all batches are durable; not OK: none is, unless the outcome is unknown. In the
  // order of their revisions. Errors as JournalError.
  absl::Status Append(std::span<const Batch> batches);

  // Of a mesh that another server writes: it wrote a batch that executed `work`; a snapshot.
  void SawEntry(std::uint64_t revision, std::uint64_t bytes, const WorkCounters& work) {
    sizes_.Add(revision, bytes, work);
  }
  void SawSnapshot(std::uint64_t bytes) { sizes_ = {.snapshot = bytes}; }

  // False after an append that was fenced or has an unknown outcome: nothing more can be written.
  bool owns() const { return owns_; }

  // Reads what this writes. `empty`: as MeshHistory's.
  MeshHistory History(const MeshHash& empty) const {
    return MeshHistory(journal_, key_, id_, dimension_, empty);
  }

  // The mesh's last revision has the features of the previous one, and other bits (kMeshBits).
  // Writes that revision and a snapshot. Errors as Append; a failed snapshot is logged.
  absl::Status AppendOtherBits(const DynamicMesh& mesh);

  // True if a snapshot is due. O(1).
  bool IsDue(const DynamicMesh& mesh) const;
  // To be called after a batch, when the mesh is at the last revision that was written; O(1) unless
  // a snapshot is due. A failure is logged, and retried later.
  void CompactIfDue(const DynamicMesh& mesh);

 private:
  void Compact(const DynamicMesh& mesh);

  Journal* const journal_;
  const Journal::Key key_;
  const std::string id_;
  const int dimension_;
  const Limits limits_;
  Sizes sizes_;
  bool owns_ = true;
  std::uint64_t failed_at_ = 0;  // bytes of entries at the last failed snapshot
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_MESH_LOG_H_
