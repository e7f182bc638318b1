// A pipeline of edit batches to one mesh: it sends batches before earlier ones are answered. For
// simulation loops.
//
//   auto session = client->OpenEdits("plate");
//   for (const dynmesh::EditBatch& batch : batches) {
//     if (!session->Send(batch).ok()) break;
//   }
//   session->DoneSending();
//   while (auto answer = session->Receive()) Use(answer->result);
//   absl::Status status = session->Finish();
//
// One thread may call Send and DoneSending while another calls Receive. The server stops reading
// while too many answers are not received. So Send blocks a caller that sends many batches without
// receiving. The destructor cancels unfinished batches. A session does not reconnect. If another
// server takes the mesh over, its batches are refused with UNAVAILABLE (NOT_OWNER), or the stream
// ends with UNAVAILABLE; a new session goes to that server. With request ids the batches without an
// answer can be sent again.
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

// Parameters of a batch.
struct EditParams {
  // Makes a retry safe: the server remembers the last 10,000 ids of a mesh and answers a repeated
  // batch with its first result. At most 128 bytes (INVALID_ARGUMENT, BAD_REQUEST_ID).
  // ALREADY_EXISTS (REQUEST_ID_REUSED) if the edits differ.
  std::string request_id;
  // If set, the mesh must be at this revision, else ABORTED (REVISION_MISMATCH).
  std::optional<std::uint64_t> expected_revision;
  bool validate_only = false;  // only check the batch; change nothing
  bool omit_columns = false;   // return revisions, work and hash only
  // The dimension of the mesh: in 3D, positions have a z. INVALID_ARGUMENT (WRONG_DIMENSION) if it
  // is not the mesh's.
  int dimension = 2;
};

// The result of a batch.
struct EditResult {
  MeshDiff diff;                 // from the revision before
  bool replayed = false;         // a retry of a batch that had been applied
  bool columns_omitted = false;  // diff has no columns
};

// A stream of batches; see edit_session.h.
class EditSession {
 public:
  // The answer to one batch.
  struct Answer {
    std::string request_id;             // the batch's
    absl::StatusOr<EditResult> result;  // or why it was refused (errors: MeshClient::Apply)
  };

  virtual ~EditSession() = default;

  // Sends `edits` as one batch, as `params` say. Blocks while the server reads no more.
  // INVALID_ARGUMENT if `params`.dimension is not 2 or 3. UNAVAILABLE if the stream has ended: then
  // call Receive until it returns nothing, and Finish.
  virtual absl::Status Send(const EditBatch& edits, const EditParams& params = {}) = 0;
  // Ends the sequence of batches. UNAVAILABLE if the stream has ended.
  virtual absl::Status DoneSending() = 0;
  // Waits for the answer to the next batch, in the order sent; nothing if the stream has ended.
  virtual std::optional<Answer> Receive() = 0;
  // The status with which the stream ended. Call it after Receive has returned nothing. CANCELLED
  // after Cancel; UNAVAILABLE if the server ended it, as it shuts down or the token lost the right;
  // DEADLINE_EXCEEDED (BATCH_INCOMPLETE) if no batch was sent for too long after opening; else as
  // of MeshClient.
  virtual absl::Status Finish() = 0;
  // Ends the stream from any thread. Batches that the server has not applied change nothing.
  virtual void Cancel() = 0;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_EDIT_SESSION_H_
