// The files of a journal's folder, and the header of an SQLite database before its tables are read.
// Thread-safe.
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
  kWhole,    // complete in one file, as made by SQLite's VACUUM INTO
  kWithLog,  // in WAL mode: the last changes may be in a log beside it
};
DatabaseFormat DatabaseFormatOf(const std::string& path);

// 0 if the file is missing.
std::uint64_t FileSizeOf(const std::string& path);

// Files that do not belong to the journal, separated by spaces: perhaps a backup under another
// name.
std::string OtherFilesIn(const std::string& folder);

// Makes the file if it is missing, readable by its owner only. SQLite gives its other files the
// same rights.
absl::Status MakeDatabaseFile(const std::string& path);

// HeadsFile::kIdBytes random bytes.
std::string RandomJournalId();
// For a journal of the present schema.
absl::StatusOr<std::string> JournalIdOf(sqlite::Connection& connection);

// The first number of the result; 0 if there is none.
absl::StatusOr<std::int64_t> NumberOf(sqlite::Connection& connection, const char* sql);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_JOURNAL_FOLDER_H_
