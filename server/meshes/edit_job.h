// A batch of edits on its way through a mesh's writer, and its outcome. Plain data.
#ifndef DYNMESH_SERVER_MESHES_EDIT_JOB_H_
#define DYNMESH_SERVER_MESHES_EDIT_JOB_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/access/quota.h"
#include "server/meshes/batch_progress.h"
#include "server/metrics/server_metrics.h"
#include "server/revisions/diff_algebra.h"
#include "server/revisions/request_memory.h"

namespace dynmesh::server {

// The outcome of a batch.
struct EditOutcome {
  std::shared_ptr<const MeshDiff> diff;
  bool replayed = false;         // a retry: it had been applied before
  bool columns_omitted = false;  // a retry; its diff is no longer held
};
// Of the diff.
inline std::size_t BytesOf(const EditOutcome& outcome) { return ByteSize(*outcome.diff); }

struct EditJob {
  EditBatch edits;
  std::string request_id;
  std::string call_id;  // of its call, for the log
  // As in Pass::client(): has half of the places where batches wait at most. Empty: may have all.
  std::string client;
  std::shared_ptr<Share> waiting;         // the client's place, while the job waits; may be null
  EditSource source = EditSource::kEdit;  // for metrics
  std::optional<std::uint64_t> expected_revision;
  bool validate_only = false;
  // Not OK: the batch is invalid. It is answered with this in its turn and not applied.
  absl::Status refused;
  // If set: makes the edits in the job's turn, unless the job is a retry.
  std::function<absl::StatusOr<EditBatch>(const DynamicMesh&)> make;
  // The fingerprint that a retry must share; none: that of the edits.
  std::optional<Fingerprint> content;
  // If the batch results in another hash, it is undone: DATA_LOSS.
  std::optional<MeshHash> expected_hash;
  // True after the call was cancelled or its deadline passed. May be null.
  std::shared_ptr<const std::atomic<bool>> cancelled;
  // Shared by the batches of a stream that ends at the first refused one; may be null.
  std::shared_ptr<std::atomic<bool>> stop;
  // Called on the strand with the progress: as ApplyOptions::progress, then of the journal. May be
  // null.
  std::function<void(const BatchProgress&)> progress;
  // Called once, on the strand or by Withdraw.
  std::function<void(absl::StatusOr<EditOutcome>)> done;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_EDIT_JOB_H_
