// Names of meshes, and errors that name a mesh. Pure functions, thread-safe.
#ifndef DYNMESH_SERVER_BASE_MESH_NAME_H_
#define DYNMESH_SERVER_BASE_MESH_NAME_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

// Converts "meshes/{id}" to the id and back. INVALID_ARGUMENT (BAD_NAME) if `name` has not that
// form. A damaged mesh with an unreadable id is named by its row in the journal: "meshes/@{key}".
absl::StatusOr<std::string> ParseMeshName(absl::string_view name);
std::string MeshName(absl::string_view id);
bool IsMeshId(absl::string_view id);
// "@{key}", and a test for such a name.
std::string RowName(std::int64_t key);
bool IsRowName(absl::string_view id);

// INVALID_ARGUMENT (BAD_NAME) for the value `name` of `field`.
absl::Status BadName(absl::string_view field, absl::string_view name, absl::string_view form);

// "meshes/{id} {what}".
absl::Status MeshError(absl::StatusCode code, const char* reason, absl::string_view id,
                       absl::string_view what);
absl::Status MeshDeletedError(absl::string_view id);
// NOT_FOUND (MESH_NOT_FOUND).
absl::Status MeshNotFoundError(absl::string_view id);
// FAILED_PRECONDITION (NO_HISTORY).
absl::Status NoHistoryError(absl::string_view id);
// The server that has a mesh.
struct MeshOwner {
  std::string address;  // empty: not known
  std::int64_t epoch = 0;
};
// UNAVAILABLE (NOT_OWNER, with RetryInfo): another server has the mesh. If its address is known,
// the metadata have `owner` and `epoch`.
absl::Status NotOwnerError(absl::string_view id, const MeshOwner& owner = {});
// The same reason: this server may have the mesh, but has not confirmed it in time for a read.
absl::Status UnconfirmedError(absl::string_view id);
// Translates an error of writing to the mesh's journal for clients: NOT_FOUND (MESH_DELETED),
// UNAVAILABLE (JOURNAL_FAILED, with RetryInfo) if it may be temporary, NotOwnerError for ABORTED,
// UNAVAILABLE (OUTCOME_UNKNOWN, with RetryInfo) for UNKNOWN, else DATA_LOSS (JOURNAL_FAILED). An
// error with details for clients, such as DRAINING, stays as it is.
absl::Status JournalError(const absl::Status& status, absl::string_view id);
// The same for reading a mesh that is to be opened, where nothing is to be written.
absl::Status JournalReadError(const absl::Status& status, absl::string_view id);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_MESH_NAME_H_
