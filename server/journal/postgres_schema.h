// The tables of the journal in PostgreSQL, all in the schema `dynmesh`. Those of version 3, the first:
//
//   journal      one row: the schema's version
//   meshes       key, id, description, checksum; snapshot: revision of the newest; head: the last
//                revision; answers: the number of the last request; tail_bytes: of the entries
//                since the snapshot; owner: the journal object that claimed the mesh last, and
//                epoch: how often that or a resolution happened (postgres_ownership.h)
//   generations  a row per complete snapshot, by mesh and revision, as in SQLite (sqlite_schema.h)
//   snapshots    parts, by mesh, revision and number; checksum
//   entries      batches, by mesh and revision; the epoch that wrote it; checksum
//   requests     answers, by mesh and number; checksum
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_SCHEMA_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_SCHEMA_H_

#include "absl/status/status.h"
#include "server/journal/postgres_session.h"
#include "server/journal/schemas.h"

namespace dynmesh::server::postgres {

// The version of the schema; also counts changes of meshes' bits, as SQLite's does.
inline constexpr int kPostgresSchema = 6;

// Those of this program; present() is kPostgresSchema.
const Schemas& SchemasOfDatabases();

// Makes the tables in one transaction, or upgrades them, or checks that they are there; several
// servers may start at once. FAILED_PRECONDITION for a newer version, for one before the first, and
// if the user may not make or upgrade them; UNAVAILABLE as Session::Run.
absl::Status PrepareSchema(Session& session, const Schemas& schemas = SchemasOfDatabases());

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_SCHEMA_H_
