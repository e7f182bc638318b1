#include "server/journal/sqlite_schema.h"

#include <cstddef>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;

// kSteps[n] leads from schema n to the next. A new file goes through all steps, so it has the same
// tables as an upgraded one. Rows are small or far larger than a page; WITHOUT ROWID saves each
// table a second tree.
constexpr const char* kSteps[kJournalSchema] = {
    R"(
  CREATE TABLE meshes(
    key INTEGER PRIMARY KEY AUTOINCREMENT,
    id TEXT NOT NULL UNIQUE,
    description BLOB NOT NULL,
    snapshot INTEGER NOT NULL,
    head INTEGER NOT NULL);
  CREATE TABLE snapshots(
    mesh INTEGER NOT NULL, part INTEGER NOT NULL, data BLOB NOT NULL,
    PRIMARY KEY(mesh, part)) WITHOUT ROWID;
  CREATE TABLE entries(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, data BLOB NOT NULL,
    PRIMARY KEY(mesh, revision)) WITHOUT ROWID;
  CREATE TABLE requests(
    mesh INTEGER NOT NULL, number INTEGER NOT NULL, id TEXT NOT NULL, answer BLOB NOT NULL,
    PRIMARY KEY(mesh, number)) WITHOUT ROWID;
  CREATE TABLE probes(number INTEGER PRIMARY KEY);
  INSERT INTO probes VALUES(0);
)",
    // A snapshot without any part remains missing.
    R"(
  ALTER TABLE meshes ADD COLUMN tail_bytes INTEGER NOT NULL DEFAULT 0;
  ALTER TABLE meshes ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
  UPDATE meshes SET checksum = row_sum(id, description),
    tail_bytes = (SELECT ifnull(sum(length(data)), 0) FROM entries WHERE mesh = key);
  CREATE TABLE generations(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, parts INTEGER NOT NULL,
    bytes INTEGER NOT NULL,
    PRIMARY KEY(mesh, revision)) WITHOUT ROWID;
  INSERT INTO generations SELECT key, snapshot,
    max(snapshot > 0, (SELECT count(*) FROM snapshots WHERE mesh = key)),
    (SELECT ifnull(sum(length(data)), 0) FROM snapshots WHERE mesh = key) FROM meshes;
  ALTER TABLE snapshots RENAME TO old_snapshots;
  CREATE TABLE snapshots(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, part INTEGER NOT NULL, data BLOB NOT NULL,
    checksum INTEGER NOT NULL,
    PRIMARY KEY(mesh, revision, part)) WITHOUT ROWID;
  INSERT INTO snapshots SELECT mesh, snapshot, part, data, row_sum(mesh, snapshot, part, data)
    FROM old_snapshots JOIN meshes ON key = mesh;
  DROP TABLE old_snapshots;
  ALTER TABLE entries ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
  UPDATE entries SET checksum = row_sum(mesh, revision, data);
  ALTER TABLE requests ADD COLUMN checksum INTEGER NOT NULL DEFAULT 0;
  UPDATE requests SET checksum = row_sum(mesh, number, id, answer);
)",
    R"(
  CREATE TABLE journal(id BLOB NOT NULL);
)",
    // Rows name the bits that their hashes belong to (kMeshBits). An older dynmeshd without bits
    // would take them for damage.
    "",
    // Bits 3. An older dynmeshd would recover their meshes with bits 2.
    "",
    // Bits 4.
    "",
    // Bits 5. Descriptions name min_dihedral; those without it are of meshes without
    // (DecodeJournalMesh).
    "",
    // Bits 6.
    "",
    // Descriptions name the kind of mesh. An older dynmeshd would recover a quadtree as a Delaunay
    // mesh.
    "",
    // Entries and snapshots have labels of features. An older dynmeshd would drop them.
    "",
    // Bits 7.
    ""};

// The SQL function row_sum(...): RowSumOf.
void SumOfColumns(sqlite3_context* context, int count, sqlite3_value** columns) {
  RowSum sum;
  for (int i = 0; i < count; ++i) {
    if (sqlite3_value_type(columns[i]) == SQLITE_INTEGER) {
      sum.Add(std::int64_t{sqlite3_value_int64(columns[i])});
      continue;
    }
    const void* data = sqlite3_value_blob(columns[i]);
    const auto size = static_cast<std::size_t>(sqlite3_value_bytes(columns[i]));
    sum.Add(absl::string_view(static_cast<const char*>(data), size));
  }
  sqlite3_result_int64(context, sum.value());
}

absl::StatusOr<std::int64_t> VersionOf(Connection& connection) {
  Statement statement(connection, "PRAGMA user_version");
  const bool row = statement.Step();
  if (!statement.status().ok()) return statement.status();
  return row ? statement.Integer(0) : 0;
}

}  // namespace

absl::Status CheckJournalSchema(std::int64_t schema) {
  if (schema <= kJournalSchema) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat("it has schema ", schema,
                                                    ", this dynmeshd knows ", kJournalSchema,
                                                    ": take the newer version that wrote it"));
}

absl::Status PrepareJournal(Connection& connection, const std::string& path, absl::string_view id) {
  if (absl::Status s = connection.Run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
                                      "PRAGMA journal_size_limit=67108864");
      !s.ok()) {
    return s;
  }
  const absl::StatusOr<std::int64_t> version = VersionOf(connection);
  if (!version.ok()) return version.status();
  if (absl::Status s = CheckJournalSchema(*version); !s.ok()) return s;
  if (*version == kJournalSchema) return absl::OkStatus();
  const int made = sqlite3_create_function_v2(connection.get(), "row_sum", -1, SQLITE_UTF8, nullptr,
                                              &SumOfColumns, nullptr, nullptr, nullptr);
  if (absl::Status s = connection.StatusOf(made, "row_sum"); !s.ok()) return s;
  std::string sql = "BEGIN IMMEDIATE;";
  for (std::int64_t step = *version; step < kJournalSchema; ++step) sql += kSteps[step];
  if (*version < kSchemaWithId) {
    absl::StrAppend(&sql, "INSERT INTO journal VALUES(x'", absl::BytesToHexString(id), "');");
  }
  absl::StrAppend(&sql, "PRAGMA user_version=", kJournalSchema, ";COMMIT");
  absl::Status status = connection.Run(sql.c_str());
  if (status.ok() && *version > 0) {
    Log(LogLevel::kInfo, "journal_upgraded",
        {{"journal", path}, {"from", *version}, {"to", kJournalSchema}});
  }
  return status;
}

}  // namespace dynmesh::server
