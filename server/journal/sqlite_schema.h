// The tables of the journal in SQLite, and the upgrade from older versions. The tables are those of schema 11, the first:
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
#include "server/journal/schemas.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

// The schema's number in the file. It also counts changes of meshes' bits.
inline constexpr int kJournalSchema = 14;

// Those of this program; present() is kJournalSchema.
const Schemas& SchemasOfJournals();

// Configures the connection, and makes the tables or upgrades an older schema, in one transaction;
// an upgrade takes O(file). `id`: given to a new journal. Errors: as CheckSchema.
absl::Status PrepareJournal(sqlite::Connection& connection, const std::string& path,
                            absl::string_view id, const Schemas& schemas = SchemasOfJournals());

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SQLITE_SCHEMA_H_
