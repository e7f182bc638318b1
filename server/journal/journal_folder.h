// The files of a journal's folder, and what an SQLite database says of itself before its tables are
// read. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_JOURNAL_FOLDER_H_
#define DYNMESH_SERVER_JOURNAL_JOURNAL_FOLDER_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

enum class DatabaseFormat {
  kNone,     // no header
  kWhole,    // by itself, as SQLite's VACUUM INTO makes it
  kWithLog,  // in WAL mode: what was written last may be in a log beside it
};
DatabaseFormat DatabaseFormatOf(const std::string& path);

// 0 if it is not there.
std::uint64_t FileSizeOf(const std::string& path);

// Files that are not the journal's, with spaces between: perhaps a backup under another name.
std::string OtherFilesIn(const std::string& folder);

// Unless it is there: for its owner alone to read. SQLite gives its other files the same rights.
absl::Status MakeDatabaseFile(const std::string& path);

// HeadsFile::kIdBytes.
std::string RandomJournalId();
// In a journal of the present schema.
absl::StatusOr<std::string> JournalIdOf(sqlite::Connection& connection);

// The first number of the answer; 0 if there is none.
absl::StatusOr<std::int64_t> NumberOf(sqlite::Connection& connection, const char* sql);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_JOURNAL_FOLDER_H_
