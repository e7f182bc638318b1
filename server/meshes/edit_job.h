// A batch of edits on its way through a mesh's writer, and what became of it. Plain data.
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
#include "server/meshes/batch_progress.h"
#include "server/metrics/server_metrics.h"
#include "server/revisions/request_memory.h"

namespace dynmesh::server {

// What became of a batch.
struct EditOutcome {
  std::shared_ptr<const MeshDiff> diff;
  bool replayed = false;         // it had been applied before
  bool columns_omitted = false;  // of such a one the diff is no longer held
};

struct EditJob {
  EditBatch edits;
  std::string request_id;
  std::string call_id;                    // of the call that brought it, for the log
  EditSource source = EditSource::kEdit;  // for metrics
  std::optional<std::uint64_t> expected_revision;
  bool validate_only = false;
  // Not OK: known to be bad; answered with this in its turn and not applied.
  absl::Status refused;
  // Given: makes the edits, in the job's turn, when it is known not to be a retry.
  std::function<absl::StatusOr<EditBatch>(const DynamicMesh&)> make;
  // What a retry must have in common; none: the edits.
  std::optional<Fingerprint> content;
  // The hash that must come out, or the batch is undone: DATA_LOSS.
  std::optional<MeshHash> expected_hash;
  // Turns true when the call is cancelled or its deadline passes. May be null.
  std::shared_ptr<const std::atomic<bool>> cancelled;
  // Shared by the batches of a stream that ends at the first refused one; may be null.
  std::shared_ptr<std::atomic<bool>> stop;
  // Told, on the strand, how far it is: as ApplyOptions::progress, then of the journal. May be
  // null.
  std::function<void(const BatchProgress&)> progress;
  // Called once, on the strand or by Withdraw.
  std::function<void(absl::StatusOr<EditOutcome>)> done;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_EDIT_JOB_H_
