// A pipeline of edit batches to one mesh: batches go out before the answers to earlier
// ones are in. For simulation loops.
//
// Send and Receive may be called from two threads, each from one at a time. The server
// stops reading when too many answers wait to be taken: who sends many batches without
// receiving will block. Destroying a session cancels what is under way.
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

struct EditParams {
  // Makes a retry safe: the server remembers the last 10,000 of a mesh.
  std::string request_id;
  std::optional<std::uint64_t> expected_revision;
  bool validate_only = false;
  bool omit_columns = false;  // only revisions, work and hash are wanted
  // That of the mesh: in space places have a z. The server refuses what does not fit
  // (WRONG_DIMENSION).
  int dimension = 2;
};

struct EditResult {
  MeshDiff diff;
  bool replayed = false;         // a retry: it had been applied before
  bool columns_omitted = false;  // diff has no columns
};

class EditSession {
 public:
  struct Answer {
    std::string request_id;
    absl::StatusOr<EditResult> result;
  };

  virtual ~EditSession() = default;

  // Blocks while the server takes no more. UNAVAILABLE or the like if the stream has
  // ended: Receive what is left, then Finish tells why.
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
