// The tables of the journal in SQLite, and the upgrade from older versions. Schema 11:
//
//   journal      one row: the journal's id, which is also in journal.heads (heads_file.h)
//   meshes       key, id, description, checksum; snapshot: revision of the newest; head: the last
//                revision; tail_bytes: of the entries since the snapshot
//   generations  a row per complete snapshot, by mesh and revision: its parts, its bytes and, once
//                there is a newer one, the bytes of the entries in between. The first has revision
//                0 and no parts. Rows elsewhere that belong to no generation are leftovers
//   snapshots    parts, by mesh, revision and number; checksum
//   entries      batches, by mesh and revision; checksum
//   requests     answers, by mesh and number; checksum
//   probes       written to test whether writing works
#ifndef DYNMESH_SERVER_JOURNAL_SQLITE_SCHEMA_H_
#define DYNMESH_SERVER_JOURNAL_SQLITE_SCHEMA_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

// The schema's number in the file.
inline constexpr int kJournalSchema = 11;
// From this schema on a journal has an id, a record of its heads, and the present tables.
inline constexpr int kSchemaWithId = 3;

// FAILED_PRECONDITION for a newer one.
absl::Status CheckJournalSchema(std::int64_t schema);

// Configures the connection, and makes the tables or upgrades an older schema, in one transaction;
// an upgrade takes O(file). `id`: given to a journal that has none. FAILED_PRECONDITION for a newer
// schema.
absl::Status PrepareJournal(sqlite::Connection& connection, const std::string& path,
                            absl::string_view id);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SQLITE_SCHEMA_H_
