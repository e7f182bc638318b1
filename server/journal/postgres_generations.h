// Generations of a mesh in PostgreSQL, as those in SQLite (sqlite_generations.h): which rows belong
// to one, which are leftovers, and the parts of changes that are too large for one transaction.
// Each function is a transaction of its own, and changes nothing unless the mesh has the given
// epoch and head. After an error the session is to be closed. Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_GENERATIONS_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_GENERATIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/postgres_ownership.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

// True if there is a complete snapshot of that revision.
absl::StatusOr<bool> HasSnapshot(Session& session, std::int64_t mesh, std::int64_t revision);

// Writes parts of the snapshot of `at.head` from `first` on: as many as have `bytes` together, at
// least one. Returns the number of the first part that is left. ABORTED if the belief is wrong.
absl::StatusOr<std::size_t> WriteParts(Session& session, std::int64_t mesh, const Belief& at,
                                       const std::vector<std::string>& parts, std::size_t first,
                                       std::uint64_t bytes);

// Begins a transaction that has the row of a mesh. If the next statement does not come for 3 s, the
// database ends it: a server that is stopped or cut off must not keep the others from its meshes.
absl::Status BeginBounded(Session& session);

// Makes the written snapshot, of which all `parts` must be there, the newest. Generations before
// the newest that have more than `history_bytes` together become leftovers, the oldest first; the
// last of them is always kept. O(generations). ABORTED if the belief is wrong.
absl::Status SwitchOver(Session& session, std::int64_t mesh, const Belief& at,
                        const std::vector<std::string>& parts, std::uint64_t history_bytes);

// Deletes leftovers of a mesh that has `epoch`, or that was deleted: about `bytes`, at least one
// row. False if there are none, or if the mesh has another epoch. Deletes nothing of a mesh whose
// newest snapshot differs from the one in its row.
absl::StatusOr<bool> SweepPart(Session& session, std::int64_t mesh, std::int64_t epoch,
                               std::uint64_t bytes);

// Deleted meshes of which there are rows. O(meshes) searches.
absl::StatusOr<std::vector<std::int64_t>> DeletedMeshes(Session& session);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_GENERATIONS_H_
