// Generations of a mesh in PostgreSQL, as those in SQLite (sqlite_generations.h): which rows belong
// to one, which are leftovers, and the parts of changes that are too large for one transaction.
// Each function is a transaction of its own, and changes nothing unless the mesh has the given
// epoch. After an error the session is to be closed. Thread-compatible.
//
// Batches are appended and the mesh is claimed beside these transactions, but for SwitchOver, which
// is short: they keep the mesh's row from being deleted or switched, not from being changed. So a
// former owner may still write parts. SwitchOver waits for the end of such a statement, then
// compares what is there with what it wrote.
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

// True if the newest snapshot is of that revision. FAILED_PRECONDITION if it is later.
absl::StatusOr<bool> CheckSnapshot(Session& session, std::int64_t mesh, std::int64_t revision);

// Writes parts of the snapshot of `revision` from `first` on: as many as have `bytes` together, at
// least one. Returns the number of the first part that is left. ABORTED if the mesh has another
// epoch, or not that revision.
absl::StatusOr<std::size_t> WriteParts(Session& session, std::int64_t mesh, std::int64_t epoch,
                                       std::int64_t revision, const std::vector<std::string>& parts,
                                       std::size_t first, std::uint64_t bytes);

// Makes the written snapshot the newest; UNAVAILABLE unless all `parts` are there, and no others.
// The entries after its revision are its own. Generations before it that have more than
// `history_bytes` together become leftovers, the oldest first; the last of them is always kept.
// O(parts + generations + entries after it). ABORTED as above.
absl::Status SwitchOver(Session& session, std::int64_t mesh, std::int64_t epoch,
                        std::int64_t revision, const std::vector<std::string>& parts,
                        std::uint64_t history_bytes);

// Deletes leftovers of a mesh that has `epoch`, or that was deleted: about `bytes`, at least one
// row. False if there are none, or if the mesh has another epoch. Deletes nothing of a mesh whose
// newest snapshot differs from the one in its row.
absl::StatusOr<bool> SweepPart(Session& session, std::int64_t mesh, std::int64_t epoch,
                               std::uint64_t bytes);

// Deleted meshes of which there are rows. O(meshes) searches.
absl::StatusOr<std::vector<std::int64_t>> DeletedMeshes(Session& session);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_GENERATIONS_H_
