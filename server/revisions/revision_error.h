// Errors about revisions that a mesh does not have or no longer has: OUT_OF_RANGE with metadata:
// the mesh's revision and, if known, the oldest one held. Pure, thread-safe.
#ifndef DYNMESH_SERVER_REVISIONS_REVISION_ERROR_H_
#define DYNMESH_SERVER_REVISIONS_REVISION_ERROR_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/revisions/revision_store.h"

namespace dynmesh::server {

absl::Status RevisionError(const char* reason, absl::string_view message, const Head& head,
                           std::optional<std::uint64_t> oldest);
// FUTURE_REVISION and COMPACTED for the revision `asked`; `advice` ends the message.
absl::Status FutureRevision(std::uint64_t asked, const Head& head,
                            std::optional<std::uint64_t> oldest, absl::string_view advice);
absl::Status CompactedRevision(std::uint64_t asked, const Head& head, std::uint64_t oldest,
                               absl::string_view advice);

// DIVERGED: at the revision `asked` the mesh had `hash`, and the client has `given`.
absl::Status DivergedRevision(std::uint64_t asked, const MeshHash& hash, const MeshHash& given,
                              const Head& head, std::uint64_t oldest, absl::string_view advice);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_REVISIONS_REVISION_ERROR_H_
