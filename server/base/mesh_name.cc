#include "server/base/mesh_name.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "proto/codec/status_codec.h"
#include "server/base/printable.h"

namespace dynmesh::server {
namespace {

constexpr absl::string_view kPrefix = "meshes/";
constexpr std::size_t kMaxIdLength = 63;
// An operator has to free disk space first.
constexpr absl::Duration kRetryJournal = absl::Seconds(1);

// Another server answers, or will soon.
constexpr absl::Duration kRetryOwner = absl::Milliseconds(100);

absl::Status RetryError(const char* reason, absl::string_view id, absl::string_view what,
                        absl::Duration after, const MeshOwner& owner = {}) {
  codec::ServiceError error;
  error.reason = reason;
  error.metadata["mesh"] = MeshName(id);
  if (!owner.address.empty()) {
    error.metadata["owner"] = owner.address;
    error.metadata["epoch"] = absl::StrCat(owner.epoch);
  }
  error.retry_after = after;
  return codec::MakeServiceError(absl::StatusCode::kUnavailable,
                                 absl::StrCat(MeshName(id), " ", what), error);
}

}  // namespace

bool IsMeshId(absl::string_view id) {
  if (id.empty() || id.size() > kMaxIdLength || id[0] < 'a' || id[0] > 'z') return false;
  return std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

std::string RowName(std::int64_t key) { return absl::StrCat("@", key); }

bool IsRowName(absl::string_view id) {
  return absl::ConsumePrefix(&id, "@") && !id.empty() && id.size() < 20 &&
         std::all_of(id.begin(), id.end(), [](char c) { return c >= '0' && c <= '9'; });
}

absl::StatusOr<std::string> ParseMeshName(absl::string_view name) {
  absl::string_view id = name;
  if (!absl::ConsumePrefix(&id, kPrefix) || !(IsMeshId(id) || IsRowName(id))) {
    return BadName("mesh", name, "meshes/{id} with an id [a-z][a-z0-9-]{0,62}");
  }
  return std::string(id);
}

std::string MeshName(absl::string_view id) { return absl::StrCat(kPrefix, id); }

absl::Status BadName(absl::string_view field, absl::string_view name, absl::string_view form) {
  codec::ServiceError error;
  error.reason = codec::reason::kBadName;
  error.field = std::string(field);
  return codec::MakeServiceError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat(field, " '", Printable(name.substr(0, 100)), "' is not of the form ", form),
      error);
}

absl::Status MeshError(absl::StatusCode code, const char* reason, absl::string_view id,
                       absl::string_view what) {
  codec::ServiceError error;
  error.reason = reason;
  error.metadata["mesh"] = MeshName(id);
  return codec::MakeServiceError(code, absl::StrCat(MeshName(id), " ", what), error);
}

absl::Status MeshDeletedError(absl::string_view id) {
  return MeshError(absl::StatusCode::kNotFound, codec::reason::kMeshDeleted, id, "was deleted");
}

absl::Status MeshNotFoundError(absl::string_view id) {
  return MeshError(absl::StatusCode::kNotFound, codec::reason::kMeshNotFound, id,
                   "does not exist: create it, or list those that do");
}

absl::Status NoHistoryError(absl::string_view id) {
  return MeshError(absl::StatusCode::kFailedPrecondition, codec::reason::kNoHistory, id,
                   "has no history, since the server keeps no journal: start it with --data-dir");
}

absl::Status NotOwnerError(absl::string_view id, const MeshOwner& owner) {
  return RetryError(codec::reason::kNotOwner, id,
                    owner.address.empty()
                        ? "is another server's: nothing was changed here. Try again there"
                        : absl::StrCat("is the server's at ", owner.address,
                                       ": nothing was changed here. Try again there"),
                    kRetryOwner, owner);
}

absl::Status UnconfirmedError(absl::string_view id) {
  return RetryError(codec::reason::kNotOwner, id,
                    "may be another server's by now, as the database has not answered in time: "
                    "try again",
                    kRetryOwner);
}

absl::Status JournalError(const absl::Status& status, absl::string_view id) {
  if (codec::GetServiceError(status).has_value()) return status;
  if (absl::IsNotFound(status)) return MeshDeletedError(id);
  if (absl::IsAborted(status)) return NotOwnerError(id);
  if (absl::IsUnknown(status)) {
    return RetryError(codec::reason::kOutcomeUnknown, id,
                      absl::StrCat("may have been changed, or not: ", status.message(),
                                   "; repeat the call with the same request_id"),
                      kRetryJournal);
  }
  const bool may_pass = absl::IsUnavailable(status);
  codec::ServiceError error;
  error.reason = codec::reason::kJournalFailed;
  error.metadata["mesh"] = MeshName(id);
  if (may_pass) error.retry_after = kRetryJournal;
  return codec::MakeServiceError(
      may_pass ? absl::StatusCode::kUnavailable : absl::StatusCode::kDataLoss,
      absl::StrCat(
          MeshName(id),
          ": nothing was changed, since it could not be written to the journal: ", status.message(),
          may_pass ? "; see to the server's disk or database and try again"
          : absl::IsFailedPrecondition(status)
              ? "; end any other process that writes to it, then restart the server"
              : "; restore the server's data folder or database"),
      error);
}

absl::Status JournalReadError(const absl::Status& status, absl::string_view id) {
  if (!absl::IsUnavailable(status) || codec::GetServiceError(status).has_value()) {
    return JournalError(status, id);
  }
  return RetryError(codec::reason::kJournalFailed, id,
                    absl::StrCat("could not be read from the journal: ", status.message(),
                                 "; nothing was changed, try again"),
                    kRetryJournal);
}

}  // namespace dynmesh::server
