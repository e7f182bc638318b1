// Reads a mesh from PostgreSQL: one consistent state, in a transaction, some rows at a time.
// Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_READING_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_READING_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/journal/journal.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

// Each function as the call of Journal with its name; after an error the session is to be closed.
// `idle`: a reader that stopped loses its transaction after this time. One that computes between
// two rows does not (postgres_keep_alive.h).
absl::StatusOr<std::vector<Journal::Mesh>> ListMeshes(Session& session);
absl::Status ReadMesh(Session& session, Journal::Key mesh, absl::Duration idle,
                      const Journal::Visitor& visitor);
absl::Status ReadPastOf(Session& session, Journal::Key mesh, absl::Duration idle,
                        std::uint64_t from, std::uint64_t to, const Journal::Visitor& visitor);
absl::StatusOr<std::uint64_t> OldestOf(Session& session, Journal::Key mesh);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_READING_H_
