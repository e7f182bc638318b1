// How meshes are named, and errors that name one. Pure functions, thread-safe.
#ifndef DYNMESH_SERVER_BASE_MESH_NAME_H_
#define DYNMESH_SERVER_BASE_MESH_NAME_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

// "meshes/{id}" to id and back. INVALID_ARGUMENT (BAD_NAME) if it is no such name. A damaged mesh
// whose id cannot be said is called by its row in the journal: "meshes/@{key}".
absl::StatusOr<std::string> ParseMeshName(absl::string_view name);
std::string MeshName(absl::string_view id);
bool IsMeshId(absl::string_view id);
// "@{key}", and whether it is such a name.
std::string RowName(std::int64_t key);
bool IsRowName(absl::string_view id);

// INVALID_ARGUMENT (BAD_NAME) for what stands in `field`.
absl::Status BadName(absl::string_view field, absl::string_view name, absl::string_view form);

// "meshes/{id} {what}".
absl::Status MeshError(absl::StatusCode code, const char* reason, absl::string_view id,
                       absl::string_view what);
absl::Status MeshDeletedError(absl::string_view id);
// FAILED_PRECONDITION (NO_HISTORY).
absl::Status NoHistoryError(absl::string_view id);
// Why the journal of that mesh refused a call, as clients are told: NOT_FOUND (MESH_DELETED),
// UNAVAILABLE (JOURNAL_FAILED, with RetryInfo) if it may pass, else DATA_LOSS (JOURNAL_FAILED).
absl::Status JournalError(const absl::Status& status, absl::string_view id);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_MESH_NAME_H_
