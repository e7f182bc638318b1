#include "server/revisions/revision_error.h"

#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::server {

absl::Status RevisionError(const char* reason, absl::string_view message, const Head& head,
                           std::optional<std::uint64_t> oldest) {
  codec::ServiceError error;
  error.reason = reason;
  error.metadata["revision"] = absl::StrCat(head.revision);
  if (oldest.has_value()) error.metadata["oldest_revision"] = absl::StrCat(*oldest);
  return codec::MakeServiceError(absl::StatusCode::kOutOfRange, message, error);
}

absl::Status FutureRevision(std::uint64_t asked, const Head& head,
                            std::optional<std::uint64_t> oldest, absl::string_view advice) {
  return RevisionError(codec::reason::kFutureRevision,
                       absl::StrCat("revision ", asked, " does not exist yet, the mesh is at ",
                                    head.revision, ": ", advice),
                       head, oldest);
}

absl::Status CompactedRevision(std::uint64_t asked, const Head& head, std::uint64_t oldest,
                               absl::string_view advice) {
  return RevisionError(
      codec::reason::kCompacted,
      absl::StrCat("revision ", asked, " is no longer held, the oldest is ", oldest, ": ", advice),
      head, oldest);
}

absl::Status DivergedRevision(std::uint64_t asked, const MeshHash& hash, const MeshHash& given,
                              const Head& head, std::uint64_t oldest, absl::string_view advice) {
  return RevisionError(codec::reason::kDiverged,
                       absl::StrCat("at revision ", asked, " the mesh had hash ", hash.ToHex(),
                                    ", not ", given.ToHex(), ": ", advice),
                       head, oldest);
}

}  // namespace dynmesh::server
