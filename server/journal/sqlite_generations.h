// Generations of a mesh in SQLite: a snapshot and the entries after it, up to the next snapshot.
// Determines the rows of a generation and the rows to delete, and splits changes that are too large
// for one transaction. All functions run in the caller's transaction. Thread-compatible.
//
// A snapshot exists from the moment it has its row in `generations`. An unfinished snapshot, and
// all that is older than the oldest row, is leftover: no reader sees it.
#ifndef DYNMESH_SERVER_JOURNAL_SQLITE_GENERATIONS_H_
#define DYNMESH_SERVER_JOURNAL_SQLITE_GENERATIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

// Writes one part of a snapshot.
absl::Status WriteSnapshotPart(sqlite::Connection& connection, std::int64_t mesh,
                               std::int64_t revision, std::int64_t number, absl::string_view data);

// Writes parts from `first` on: as many as have `bytes` together, at least one. Returns the number
// of the first part that is left.
absl::StatusOr<std::size_t> WriteParts(sqlite::Connection& connection, std::int64_t mesh,
                                       std::int64_t revision, const std::vector<std::string>& parts,
                                       std::size_t first, std::uint64_t bytes);

// Makes the written snapshot the newest. The entries after its revision are its own. Generations
// before it that have more than `history_bytes` together become leftovers, the oldest first; the
// last of them is always kept. O(generations + entries after it).
absl::Status SwitchOver(sqlite::Connection& connection, std::int64_t mesh, std::int64_t revision,
                        const std::vector<std::string>& parts, std::uint64_t history_bytes);

// Deletes leftovers of a mesh, also of a deleted one: about `bytes`, at least one row. False if
// there are none. Deletes nothing if the mesh's newest snapshot differs from the one in its row:
// then rows are damaged, and the rest may be all that is left of the mesh.
absl::StatusOr<bool> SweepPart(sqlite::Connection& connection, std::int64_t mesh,
                               std::uint64_t bytes);

// The meshes with rows, including deleted ones. O(meshes) searches.
absl::StatusOr<std::vector<std::int64_t>> MeshesWithRows(sqlite::Connection& connection);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SQLITE_GENERATIONS_H_
