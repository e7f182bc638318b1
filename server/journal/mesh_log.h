// Writes one mesh to the journal: every batch before its effects become visible, batches that are
// ready together in one write. Now and then it orders a snapshot of the features, from which the
// mesh is recovered; that is made and written beside the edits (snapshots.h).
//
// A snapshot is due when the batches since the last one exceed a minimum and outweigh it, in bytes
// or in the work to replay them: amortised O(1) for each byte and each operation of a batch. So,
// above those minimums, a generation (journal.h) has at most twice the features' bytes, and
// recovery takes at most three times as long as making the mesh from its features. The first batch,
// often a whole load, serves as a snapshot.
//
// Append blocks. Thread-compatible: the mesh's strand makes one call at a time. Appends are those
// of the writer(), the strand or one other thread at a time, beside the strand's calls about
// snapshots.
#ifndef DYNMESH_SERVER_JOURNAL_MESH_LOG_H_
#define DYNMESH_SERVER_JOURNAL_MESH_LOG_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "core/base/mutex.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/journal/journal.h"
#include "server/journal/mesh_history.h"
#include "server/journal/snapshots.h"
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
  // As EndSnapshots.
  ~MeshLog() { EndSnapshots(); }

  // A batch, and its answer, which is kept if there is a request_id.
  struct Batch {
    const EditBatch* edits = nullptr;
    absl::string_view request_id;
    RequestMemory::Entry answer;
  };
  // Returns when all batches are durable; not OK: none is, unless the outcome is unknown. In the
  // order of their revisions. Errors as JournalError.
  absl::Status Append(std::span<const Batch> batches) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_);

  // Of a mesh that another server writes: it wrote a batch that executed `work`; a snapshot, of
  // that many bytes. The few batches that it wrote while it made the snapshot are not counted.
  void SawEntry(std::uint64_t revision, std::uint64_t bytes, const WorkCounters& work);
  void SawSnapshot(std::uint64_t bytes);

  // False after an append that was fenced or has an unknown outcome: nothing more can be written.
  bool owns() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_) { return owns_; }
  // The part of the thread that appends.
  const ThreadRole& writer() const ABSL_LOCK_RETURNED(writer_) { return writer_; }

  // Reads what this writes. `empty`: as MeshHistory's.
  MeshHistory History(const MeshHash& empty) const {
    return MeshHistory(journal_, key_, id_, dimension_, empty);
  }

  // The mesh's last revision has the features of the previous one, and other bits (kMeshBits).
  // Writes that revision and a snapshot, and blocks meanwhile. Errors as Append; a failed snapshot
  // is logged.
  absl::Status AppendOtherBits(const DynamicMesh& mesh) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_);

  // Snapshots, on the strand. True if one is due and none is being made. O(1).
  bool IsDue(const DynamicMesh& mesh) const;
  // Orders a snapshot of the last revision that was written. O(1). A failure is logged, and the
  // next one is due when as much again was written.
  void OrderSnapshot(Snapshots& snapshots);
  // True if the features that the journal has cannot be read: then the snapshot that is due is to
  // be made from the mesh. That takes O(features) here, and makes the journal good again.
  bool needs_features() const;
  // The same of the mesh, which is at the last revision that was written.
  void OrderSnapshot(Snapshots& snapshots, const DynamicMesh& mesh);
  // Nothing more is to be written. The snapshot that is being made ends soon. On any thread.
  void EndSnapshots() { *book_->ended = true; }

 private:
  // What has been written. Shared with a snapshot that is being made, which may outlive the log.
  struct Book {
    explicit Book(std::string mesh) : id(std::move(mesh)) {}

    const std::string id;
    const std::shared_ptr<std::atomic<bool>> ended = std::make_shared<std::atomic<bool>>(false);
    Mutex mutex;
    Sizes sizes ABSL_GUARDED_BY(mutex);
    // The last revision written by this log; 0: none.
    std::uint64_t last ABSL_GUARDED_BY(mutex) = 0;
    bool making ABSL_GUARDED_BY(mutex) = false;  // a snapshot
    // The last snapshot failed since the journal could not be read.
    bool unreadable ABSL_GUARDED_BY(mutex) = false;
    // Bytes of entries at the last failed snapshot.
    std::uint64_t failed_at ABSL_GUARDED_BY(mutex) = 0;
  };
  using BookPtr = std::shared_ptr<Book>;

  void Order(Snapshots& snapshots, std::optional<FeaturesAt> features);
  // `then`: the sizes at the revision of the snapshot.
  static void Take(Book& book, const Sizes& then, std::uint64_t revision,
                   const Snapshots::Made& made);

  Journal* const journal_;
  const Journal::Key key_;
  const std::string id_;
  const int dimension_;
  const Limits limits_;
  const BookPtr book_;
  ThreadRole writer_;
  bool owns_ ABSL_GUARDED_BY(writer_) = true;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_MESH_LOG_H_
