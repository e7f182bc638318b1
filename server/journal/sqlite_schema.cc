#include "server/journal/sqlite_schema.h"

#include <algorithm>
#include <array>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;

constexpr int kFirstSchema = 11;

// Rows are small or far larger than a page; WITHOUT ROWID saves each table a second tree.
constexpr char kTables[] = R"(
  CREATE TABLE meshes(
    key INTEGER PRIMARY KEY AUTOINCREMENT,
    id TEXT NOT NULL UNIQUE,
    description BLOB NOT NULL,
    snapshot INTEGER NOT NULL,
    head INTEGER NOT NULL,
    tail_bytes INTEGER NOT NULL DEFAULT 0,
    checksum INTEGER NOT NULL DEFAULT 0);
  CREATE TABLE generations(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, parts INTEGER NOT NULL,
    bytes INTEGER NOT NULL,
    PRIMARY KEY(mesh, revision)) WITHOUT ROWID;
  CREATE TABLE snapshots(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, part INTEGER NOT NULL, data BLOB NOT NULL,
    checksum INTEGER NOT NULL,
    PRIMARY KEY(mesh, revision, part)) WITHOUT ROWID;
  CREATE TABLE entries(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, data BLOB NOT NULL,
    checksum INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY(mesh, revision)) WITHOUT ROWID;
  CREATE TABLE requests(
    mesh INTEGER NOT NULL, number INTEGER NOT NULL, id TEXT NOT NULL, answer BLOB NOT NULL,
    checksum INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY(mesh, number)) WITHOUT ROWID;
  CREATE TABLE probes(number INTEGER PRIMARY KEY);
  INSERT INTO probes VALUES(0);
  CREATE TABLE journal(id BLOB NOT NULL);
)";

// A step that changes no table, as for other bits of meshes, is an empty text.
constexpr std::array<const char*, kJournalSchema - kFirstSchema> kSteps = {
    // Bits 8.
    "",
    // Bits 9.
    "",
    // Bits 10.
    ""};
static_assert(std::ranges::count(kSteps, nullptr) == 0, "each schema has a step");
constexpr Schemas kSchemas = {kFirstSchema, kTables, kSteps, "journal"};

absl::StatusOr<std::int64_t> VersionOf(Connection& connection) {
  Statement statement(connection, "PRAGMA user_version");
  const bool row = statement.Step();
  if (!statement.status().ok()) return statement.status();
  return row ? statement.Integer(0) : 0;
}

}  // namespace

const Schemas& SchemasOfJournals() { return kSchemas; }

absl::Status PrepareJournal(Connection& connection, const std::string& path, absl::string_view id,
                            const Schemas& schemas) {
  if (absl::Status s = connection.Run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
                                      "PRAGMA journal_size_limit=67108864");
      !s.ok()) {
    return s;
  }
  const absl::StatusOr<std::int64_t> version = VersionOf(connection);
  if (!version.ok()) return version.status();
  if (absl::Status s = CheckSchema(*version, schemas); !s.ok()) return s;
  if (*version == schemas.present()) return absl::OkStatus();
  const bool is_new = *version == 0;
  std::string sql = absl::StrCat("BEGIN IMMEDIATE;", StepsFrom(*version, schemas));
  if (is_new) {
    absl::StrAppend(&sql, "INSERT INTO journal VALUES(x'", absl::BytesToHexString(id), "');");
  }
  absl::StrAppend(&sql, "PRAGMA user_version=", schemas.present(), ";COMMIT");
  absl::Status status = connection.Run(sql.c_str());
  if (status.ok() && !is_new) {
    Log(LogLevel::kInfo, "journal_upgraded",
        {{"journal", path}, {"from", *version}, {"to", schemas.present()}});
  }
  return status;
}

}  // namespace dynmesh::server
