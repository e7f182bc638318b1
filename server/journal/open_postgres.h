// Opens the journal in PostgreSQL, if this program was built with it. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_OPEN_POSTGRES_H_
#define DYNMESH_SERVER_JOURNAL_OPEN_POSTGRES_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

struct PostgresOptions {
  std::size_t remembered_requests = 10'000;  // of a mesh
  // Limit of a mesh's generations before the newest. The last of them is always kept.
  std::uint64_t history_bytes = 64 << 20;
  std::uint64_t transaction_bytes = 1 << 20;  // at most, or one row
  // Connections at most, for writing and for reading. Further callers wait.
  int writing_connections = 16;
  int reading_connections = 8;
  // How long the outcome of an unknown write is looked for. A mesh's calls wait meanwhile. With
  // leases that of an append is not looked for after the end of the mesh's, nor another one for
  // longer than a lease.
  absl::Duration resolve_for = absl::Seconds(60);
  // A reader of a mesh that stopped, or is cut off, loses its transaction after this time: until
  // then the database keeps old rows for it. One that computes for longer between two rows does
  // not.
  absl::Duration reading_idle = absl::Minutes(1);
  // > 0: several servers use the database, each with such leases of its meshes. 0: this one has all
  // meshes, and takes them from any other.
  absl::Duration lease = absl::ZeroDuration();
  // Refuses a database that a server uses: that has leases which have not run out, or connections
  // of dynmeshd. For copies.
  bool exclusive = false;
  // Makes the tables in an empty database; else that is NOT_FOUND.
  bool make_tables = true;
};

// `url` as of postgres::ParseTarget (postgres_target.h).
// INVALID_ARGUMENT for a malformed address; UNAVAILABLE if there is no connection;
// FAILED_PRECONDITION if a newer version wrote the tables, the user may not make them, a server
// uses the database and `exclusive`, or this program was built without PostgreSQL.
absl::StatusOr<std::unique_ptr<Journal>> OpenPostgresJournal(const std::string& url,
                                                             const PostgresOptions& options);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_OPEN_POSTGRES_H_
