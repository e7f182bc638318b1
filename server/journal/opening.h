// What is looked at before a journal is written to: whether its files belong together, whether the
// log is whole, and whether all is there that was acknowledged (wal_walk.h, heads_file.h,
// losses.h).
//
// Refused, with nothing changed: files that do not belong together. Served read only, mesh by mesh:
// meshes that lost something, until an operator accepts it. Taken over, and told: a journal from
// before there was a record, and a backup, which is a whole database without a log (SQLite's
// VACUUM INTO makes one; a copy of a journal's file says in its header that there was a log).
#ifndef DYNMESH_SERVER_JOURNAL_OPENING_H_
#define DYNMESH_SERVER_JOURNAL_OPENING_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/heads_file.h"
#include "server/journal/losses.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

struct OpenedJournal {
  sqlite::Connection connection;
  std::unique_ptr<HeadsFile> heads;
  std::vector<Loss> losses;  // not accepted
  // Not OK: the database itself is damaged, nothing may be written.
  absl::Status sealed;
};

// Of the folder, which the caller has locked. `accepted`: losses, as losses.h says.
// FAILED_PRECONDITION for files that do not belong together or of a newer version, DATA_LOSS,
// UNAVAILABLE.
absl::StatusOr<OpenedJournal> OpenJournalFiles(const std::string& folder, const char* vfs,
                                               const std::vector<std::string>& accepted);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_OPENING_H_
