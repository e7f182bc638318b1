// What a program can read of an error of the service: its reason, the features and the field to
// blame, when to try again. Pure functions, thread-safe.
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

// Reasons of the service itself; the library's stand in dynmesh/error.h. Of those that pass
// ServiceError::retry_after says when to try again.
namespace reason {
// not a message of the method, or text that is no UTF-8
inline constexpr char kBadRequest[] = "BAD_REQUEST";
inline constexpr char kBadName[] = "BAD_NAME";                // of a mesh
inline constexpr char kBadRequestId[] = "BAD_REQUEST_ID";     // too long
inline constexpr char kWrongDimension[] = "WRONG_DIMENSION";  // not the mesh's
// more edits than the server lets a batch have
inline constexpr char kBatchTooLarge[] = "BATCH_TOO_LARGE";
// a batch in pieces, or a load, without its end
inline constexpr char kBatchIncomplete[] = "BATCH_INCOMPLETE";
// the client took nothing of a stream for too long
inline constexpr char kSlowReceiver[] = "SLOW_RECEIVER";
inline constexpr char kMeshNotFound[] = "MESH_NOT_FOUND";        // there is none of that name
inline constexpr char kMeshDeleted[] = "MESH_DELETED";           // while it was used
inline constexpr char kMeshExists[] = "MESH_EXISTS";             // there is one of that name
inline constexpr char kRequestIdReused[] = "REQUEST_ID_REUSED";  // for something else than before
// the mesh is not at the expected revision
inline constexpr char kRevisionMismatch[] = "REVISION_MISMATCH";
inline constexpr char kCompacted[] = "COMPACTED";  // a revision that is not kept any more
inline constexpr char kFutureRevision[] = "FUTURE_REVISION";  // one that is not there yet
// the client's mesh is not the server's at that revision
inline constexpr char kDiverged[] = "DIVERGED";
// a server without a journal keeps no earlier features
inline constexpr char kNoHistory[] = "NO_HISTORY";
inline constexpr char kMeshLimit[] = "MESH_LIMIT";  // as many meshes as the server may have
// as many streams as the server may have; passes
inline constexpr char kStreamLimit[] = "STREAM_LIMIT";
// as many streams as a token or address may have; passes
inline constexpr char kClientStreamLimit[] = "CLIENT_STREAM_LIMIT";
inline constexpr char kQueueFull[] = "QUEUE_FULL";  // too many batches wait for the mesh; passes
// too much of edits waits in the server; passes
inline constexpr char kPendingLimit[] = "PENDING_LIMIT";
// what was asked for could not be written down, and was not done
inline constexpr char kJournalFailed[] = "JOURNAL_FAILED";
// the journal does not make the mesh again, or lacks revisions
inline constexpr char kMeshDamaged[] = "MESH_DAMAGED";
inline constexpr char kDraining[] = "DRAINING";      // the server ends; passes
inline constexpr char kRecovering[] = "RECOVERING";  // the server makes its meshes again; passes
inline constexpr char kTokenMissing[] = "TOKEN_MISSING";  // the server asks for one
inline constexpr char kTokenUnknown[] = "TOKEN_UNKNOWN";  // not one of the server's
inline constexpr char kRoleMissing[] = "ROLE_MISSING";    // the token does not allow it
// too many requests of a token or address; passes
inline constexpr char kRateLimit[] = "RATE_LIMIT";
// the server is full: removals and reads go on; passes
inline constexpr char kMemoryLimit[] = "MEMORY_LIMIT";
inline constexpr char kFeatureLimit[] = "FEATURE_LIMIT";  // as many features as a mesh may have
}  // namespace reason

// The machine-readable part of an error, whatever made it.
struct ServiceError {
  std::string reason;                           // UPPER_SNAKE
  std::map<std::string, std::string> metadata;  // keys as in status_details.proto
  std::string field;                            // path of the field to blame, if one is
  std::optional<absl::Duration> retry_after;    // when to try again, if that may help

  // The features of metadata["features"], the offender first.
  std::vector<FeatureId> Features() const;
};

// The detail of a `status` that a server answered, or that the library made (dynmesh/error.h; its
// edit index becomes the field "edits[i]"); of any other status nothing.
std::optional<ServiceError> GetServiceError(const absl::Status& status);

}  // namespace dynmesh::codec

#endif  // DYNMESH_CODEC_SERVICE_ERROR_H_
