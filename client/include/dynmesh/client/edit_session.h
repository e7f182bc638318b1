// A pipeline of edit batches to one mesh: batches go out before the answers to earlier
// ones are in. For simulation loops.
//
// Send and Receive may be called from two threads, each from one at a time. The server
// stops reading when too many answers wait to be taken: a caller that sends many batches without
// receiving blocks. Destroying a session cancels what is under way.
#ifndef DYNMESH_CLIENT_EDIT_SESSION_H_
#define DYNMESH_CLIENT_EDIT_SESSION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::client {

// What is said with a batch.
struct EditParams {
  // Makes a retry safe: the server remembers the last 10,000 of a mesh.
  std::string request_id;
  // If given, the mesh has to be at this revision: else ABORTED (REVISION_MISMATCH).
  std::optional<std::uint64_t> expected_revision;
  bool validate_only = false;  // would the batch be accepted? Nothing changes
  bool omit_columns = false;   // only revisions, work and hash are wanted
  // That of the mesh: in space places have a z. The server refuses what does not fit
  // (WRONG_DIMENSION).
  int dimension = 2;
};

// What a batch did.
struct EditResult {
  MeshDiff diff;                 // from the revision before it
  bool replayed = false;         // a retry: it had been applied before
  bool columns_omitted = false;  // diff has no columns
};

// A stream of batches; see edit_session.h.
class EditSession {
 public:
  // The answer to one batch.
  struct Answer {
    std::string request_id;             // the batch's
    absl::StatusOr<EditResult> result;  // what it did, or why it did nothing
  };

  virtual ~EditSession() = default;

  // Sends `edits` as one batch, as `params` say. Blocks while the server takes no more. UNAVAILABLE
  // or the like if the stream has ended: Receive what is left, then Finish tells why.
  virtual absl::Status Send(const EditBatch& edits, const EditParams& params = {}) = 0;
  // No batch will follow.
  virtual absl::Status DoneSending() = 0;
  // The answer to the next batch, in the order sent; nothing if the stream has ended.
  virtual std::optional<Answer> Receive() = 0;
  // How the stream ended. After Receive returned nothing.
  virtual absl::Status Finish() = 0;
  // Ends the stream from any thread.
  virtual void Cancel() = 0;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_EDIT_SESSION_H_
