// The tables of the journal in SQLite, and the steps from what an older version wrote. Schema 8:
//
//   journal      one row: the id of this journal, which stands in journal.heads, too (heads_file.h)
//   meshes       key, id, description, checksum; snapshot: revision of the newest; head: the last
//                revision; tail_bytes: of the entries since the snapshot
//   generations  a row for each whole snapshot, by mesh and revision: its parts, and its bytes and,
//                once there is a newer one, those of the entries between. The first has revision 0
//                and no parts. What belongs to none is a leftover
//   snapshots    parts, by mesh, revision and number; checksum
//   entries      batches, by mesh and revision; checksum
//   requests     answers, by mesh and number; checksum
//   probes       what is written to see whether writing works
#ifndef DYNMESH_SERVER_JOURNAL_SQLITE_SCHEMA_H_
#define DYNMESH_SERVER_JOURNAL_SQLITE_SCHEMA_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

// As numbered in the file.
inline constexpr int kJournalSchema = 8;
// From this one on a journal has an id and a record of its heads, and the tables of today.
inline constexpr int kSchemaWithId = 3;

// FAILED_PRECONDITION for a newer one.
absl::Status CheckJournalSchema(std::int64_t schema);

// Sets the connection up, and makes the tables, or those of an older schema to the present ones, in
// one transaction; O(file) for the latter. `id`: that a journal gets if it has none.
// FAILED_PRECONDITION for a newer schema.
absl::Status PrepareJournal(sqlite::Connection& connection, const std::string& path,
                            absl::string_view id);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SQLITE_SCHEMA_H_
