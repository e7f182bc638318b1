// Generations of a mesh in SQLite: a snapshot and the entries after it, up to the next snapshot.
// Which rows belong to one, what may go, and pieces of changes that are too large for one
// transaction. All run in a transaction of the caller's. Thread-compatible.
//
// A snapshot counts from the moment it has its row in `generations`; one that was not finished, and
// what is older than the oldest row, is leftover, seen by nobody.
#ifndef DYNMESH_SERVER_JOURNAL_SQLITE_GENERATIONS_H_
#define DYNMESH_SERVER_JOURNAL_SQLITE_GENERATIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

// Writes parts from `first` on, as many as have `bytes` together and at least one. The number of
// the first part that is left.
absl::StatusOr<std::size_t> WriteParts(sqlite::Connection& connection, std::int64_t mesh,
                                       std::int64_t revision, const std::vector<std::string>& parts,
                                       std::size_t first, std::uint64_t bytes);

// The snapshot that was written is the newest from now on. Of the generations before it those that
// have more than `history_bytes` together stop to count, the oldest first, the last one never.
// O(generations).
absl::Status SwitchOver(sqlite::Connection& connection, std::int64_t mesh, std::int64_t revision,
                        const std::vector<std::string>& parts, std::uint64_t history_bytes);

// Deletes leftovers of a mesh, also of one that is deleted: about `bytes`, at least a row. False if
// there are none. Nothing is one while the mesh's newest snapshot is not what the mesh says: then
// its rows are damaged, and perhaps all that is left of it.
absl::StatusOr<bool> SweepPiece(sqlite::Connection& connection, std::int64_t mesh,
                                std::uint64_t bytes);

// The meshes that have rows, deleted ones included. O(meshes) searches.
absl::StatusOr<std::vector<std::int64_t>> MeshesWithRows(sqlite::Connection& connection);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SQLITE_GENERATIONS_H_
