// Statuses across the wire: absl::Status <-> google.rpc.Status with its details.
//
// Inside the process an absl::Status carries either the library's ErrorDetail
// (dynmesh/error.h) or a ServiceError made here; on the wire both are google.rpc
// ErrorInfo, BadRequest and RetryInfo. Pure functions, thread-safe.
#ifndef DYNMESH_PROTO_CODEC_STATUS_CODEC_H_
#define DYNMESH_PROTO_CODEC_STATUS_CODEC_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "dynmesh/feature.h"

namespace dynmesh::v1 {
class Status;
}

namespace dynmesh::codec {

// Reasons of the service itself; the library's stand in dynmesh/error.h.
namespace reason {
inline constexpr char kBadRequest[] = "BAD_REQUEST";
inline constexpr char kBadName[] = "BAD_NAME";
inline constexpr char kBadRequestId[] = "BAD_REQUEST_ID";
inline constexpr char kWrongDimension[] = "WRONG_DIMENSION";
inline constexpr char kBatchTooLarge[] = "BATCH_TOO_LARGE";
inline constexpr char kBatchIncomplete[] = "BATCH_INCOMPLETE";
inline constexpr char kSlowReceiver[] = "SLOW_RECEIVER";
inline constexpr char kMeshNotFound[] = "MESH_NOT_FOUND";
inline constexpr char kMeshDeleted[] = "MESH_DELETED";
inline constexpr char kMeshExists[] = "MESH_EXISTS";
inline constexpr char kRequestIdReused[] = "REQUEST_ID_REUSED";
inline constexpr char kRevisionMismatch[] = "REVISION_MISMATCH";
inline constexpr char kCompacted[] = "COMPACTED";
inline constexpr char kFutureRevision[] = "FUTURE_REVISION";
inline constexpr char kDiverged[] = "DIVERGED";
inline constexpr char kNoHistory[] = "NO_HISTORY";
inline constexpr char kMeshLimit[] = "MESH_LIMIT";
inline constexpr char kStreamLimit[] = "STREAM_LIMIT";
inline constexpr char kClientStreamLimit[] = "CLIENT_STREAM_LIMIT";
inline constexpr char kQueueFull[] = "QUEUE_FULL";
inline constexpr char kPendingLimit[] = "PENDING_LIMIT";
inline constexpr char kJournalFailed[] = "JOURNAL_FAILED";
inline constexpr char kMeshDamaged[] = "MESH_DAMAGED";
inline constexpr char kDraining[] = "DRAINING";
inline constexpr char kRecovering[] = "RECOVERING";
inline constexpr char kTokenMissing[] = "TOKEN_MISSING";
inline constexpr char kTokenUnknown[] = "TOKEN_UNKNOWN";
inline constexpr char kRoleMissing[] = "ROLE_MISSING";
inline constexpr char kRateLimit[] = "RATE_LIMIT";
inline constexpr char kMemoryLimit[] = "MEMORY_LIMIT";
inline constexpr char kFeatureLimit[] = "FEATURE_LIMIT";
}  // namespace reason

// The machine-readable part of an error, whatever made it.
struct ServiceError {
  std::string reason;                           // UPPER_SNAKE
  std::map<std::string, std::string> metadata;  // keys as in status_details.proto
  std::string field;                            // path of the field to blame, if one is
  std::optional<absl::Duration> retry_after;

  // The features of metadata["features"], the offender first.
  std::vector<FeatureId> Features() const;
};

// A status with `error` attached.
absl::Status MakeServiceError(absl::StatusCode code, absl::string_view message,
                              const ServiceError& error);

// The detail of a status made by MakeServiceError, by dynmesh::MakeError (whose edit
// index becomes the field "edits[i]") or by StatusFromProto; else nothing.
std::optional<ServiceError> GetServiceError(const absl::Status& status);

// Long messages are cut to 1 kB and feature lists to 32: a status must fit the 8 kB
// that HTTP/2 peers take as headers. `edits_field` names the request's list of edits.
v1::Status StatusToProto(const absl::Status& status, absl::string_view edits_field = "edits");
absl::Status StatusFromProto(const v1::Status& proto);

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_STATUS_CODEC_H_
