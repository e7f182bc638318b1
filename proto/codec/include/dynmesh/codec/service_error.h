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

// The detail of a status that a server answered, or that the library made (dynmesh/error.h; its
// edit index becomes the field "edits[i]"); of any other status nothing.
std::optional<ServiceError> GetServiceError(const absl::Status& status);

}  // namespace dynmesh::codec

#endif  // DYNMESH_CODEC_SERVICE_ERROR_H_
