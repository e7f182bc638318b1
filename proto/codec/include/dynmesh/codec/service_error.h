// The machine-readable part of an error of the service: the reason, the features and the field to
// blame, when to retry. Pure functions, thread-safe.
//
//   if (auto error = dynmesh::codec::GetServiceError(status)) {
//     if (error->retry_after) absl::SleepFor(*error->retry_after);  // then repeat the call
//   }
#ifndef DYNMESH_CODEC_SERVICE_ERROR_H_
#define DYNMESH_CODEC_SERVICE_ERROR_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "dynmesh/feature.h"

namespace dynmesh::codec {

// Reasons of the service itself; those of the library are in dynmesh/error.h. "Retry" means that
// ServiceError::retry_after says when to retry.
namespace reason {
// INVALID_ARGUMENT: not a message of the method, or text that is not UTF-8.
inline constexpr char kBadRequest[] = "BAD_REQUEST";
inline constexpr char kBadName[] = "BAD_NAME";                // INVALID_ARGUMENT: of a mesh
inline constexpr char kBadRequestId[] = "BAD_REQUEST_ID";     // INVALID_ARGUMENT: too long
inline constexpr char kWrongDimension[] = "WRONG_DIMENSION";  // INVALID_ARGUMENT
// INVALID_ARGUMENT: more edits than the server allows in a batch.
inline constexpr char kBatchTooLarge[] = "BATCH_TOO_LARGE";
// INVALID_ARGUMENT, DEADLINE_EXCEEDED: a batch in parts, or a load, without its end.
inline constexpr char kBatchIncomplete[] = "BATCH_INCOMPLETE";
// DEADLINE_EXCEEDED: the client received nothing of a stream for too long.
inline constexpr char kSlowReceiver[] = "SLOW_RECEIVER";
inline constexpr char kMeshNotFound[] = "MESH_NOT_FOUND";  // NOT_FOUND
inline constexpr char kMeshDeleted[] = "MESH_DELETED";     // NOT_FOUND: while in use
inline constexpr char kMeshExists[] = "MESH_EXISTS";       // ALREADY_EXISTS
// ALREADY_EXISTS: with other content.
inline constexpr char kRequestIdReused[] = "REQUEST_ID_REUSED";
// ABORTED: the mesh is not at the expected revision.
inline constexpr char kRevisionMismatch[] = "REVISION_MISMATCH";
inline constexpr char kCompacted[] = "COMPACTED";  // OUT_OF_RANGE: a revision no longer held
// OUT_OF_RANGE: a revision that does not exist yet.
inline constexpr char kFutureRevision[] = "FUTURE_REVISION";
// OUT_OF_RANGE: the client's mesh is not the server's at that revision.
inline constexpr char kDiverged[] = "DIVERGED";
// FAILED_PRECONDITION: a server without a journal has no earlier features.
inline constexpr char kNoHistory[] = "NO_HISTORY";
// RESOURCE_EXHAUSTED: the server's number of meshes.
inline constexpr char kMeshLimit[] = "MESH_LIMIT";
// RESOURCE_EXHAUSTED, retry: the server's number of streams.
inline constexpr char kStreamLimit[] = "STREAM_LIMIT";
// RESOURCE_EXHAUSTED, retry: the number of streams of a token or address.
inline constexpr char kClientStreamLimit[] = "CLIENT_STREAM_LIMIT";
// RESOURCE_EXHAUSTED, retry: too many batches wait.
inline constexpr char kQueueFull[] = "QUEUE_FULL";
// RESOURCE_EXHAUSTED, retry: too many bytes of edits wait in the server.
inline constexpr char kPendingLimit[] = "PENDING_LIMIT";
// UNAVAILABLE with retry, or DATA_LOSS: the change could not be written and was not made.
inline constexpr char kJournalFailed[] = "JOURNAL_FAILED";
// UNAVAILABLE, retry: another server has the mesh.
inline constexpr char kNotOwner[] = "NOT_OWNER";
// UNAVAILABLE, retry with the same request_id: the connection to the journal's database was lost,
// and it is unknown whether the change was made.
inline constexpr char kOutcomeUnknown[] = "OUTCOME_UNKNOWN";
// DATA_LOSS: the journal cannot restore the mesh, or lacks revisions.
inline constexpr char kMeshDamaged[] = "MESH_DAMAGED";
inline constexpr char kDraining[] = "DRAINING";      // UNAVAILABLE, retry: the server stops
inline constexpr char kRecovering[] = "RECOVERING";  // UNAVAILABLE, retry: the server is starting
inline constexpr char kTokenMissing[] = "TOKEN_MISSING";  // UNAUTHENTICATED
// UNAUTHENTICATED: not one of the server's.
inline constexpr char kTokenUnknown[] = "TOKEN_UNKNOWN";
// PERMISSION_DENIED: not allowed for the token.
inline constexpr char kRoleMissing[] = "ROLE_MISSING";
// RESOURCE_EXHAUSTED, retry: too many requests of a token or address.
inline constexpr char kRateLimit[] = "RATE_LIMIT";
// RESOURCE_EXHAUSTED, retry: the server is full; removals and reads are still possible.
inline constexpr char kMemoryLimit[] = "MEMORY_LIMIT";
inline constexpr char kFeatureLimit[] = "FEATURE_LIMIT";  // RESOURCE_EXHAUSTED: features of a mesh
inline constexpr char kTimeLimit[] = "TIME_LIMIT";        // RESOURCE_EXHAUSTED: of a build
}  // namespace reason

// The machine-readable part of an error, of the service or the library.
struct ServiceError {
  std::string reason;                           // UPPER_SNAKE
  std::map<std::string, std::string> metadata;  // keys as in status_details.proto
  std::string field;                            // path of the field to blame, if any
  std::optional<absl::Duration> retry_after;    // when to retry, if that may help

  // The features of metadata["features"], the one to blame first.
  std::vector<FeatureId> Features() const;
};

// The detail of a `status` from a server or from the library (dynmesh/error.h; its edit index
// becomes the field "edits[i]"); nothing for any other status.
std::optional<ServiceError> GetServiceError(const absl::Status& status);

}  // namespace dynmesh::codec

#endif  // DYNMESH_CODEC_SERVICE_ERROR_H_
