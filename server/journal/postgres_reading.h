// Reads a mesh from PostgreSQL: one consistent state, in a transaction, some rows at a time.
// Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_READING_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_READING_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/journal.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

// Each function as the call of Journal with its name; after an error the session is to be closed.
absl::StatusOr<std::vector<Journal::Mesh>> ListMeshes(Session& session);
absl::Status ReadMesh(Session& session, Journal::Key mesh, const Journal::Visitor& visitor);
absl::Status ReadPastOf(Session& session, Journal::Key mesh, std::uint64_t from, std::uint64_t to,
                        const Journal::Visitor& visitor);
absl::StatusOr<std::uint64_t> OldestOf(Session& session, Journal::Key mesh);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_READING_H_
