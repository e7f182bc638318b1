// Checks before a journal is written: whether its files belong together, whether the log is
// undamaged, and whether all acknowledged data is present (wal_walk.h, heads_file.h, losses.h).
//
// Files that do not belong together are refused, with nothing changed. Meshes with losses are
// served read only until an operator accepts the losses. Two kinds of journal are taken over and
// logged: one older than the record, and a backup, which is a whole database without a log.
// (SQLite's VACUUM INTO makes one. A plain copy of a journal's file is not one: its header says
// that there was a log.)
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
  // Not OK: the database itself is damaged and read only.
  absl::Status sealed;
};

// Opens `folder`, which the caller has locked. `accepted`: losses, as in losses.h.
// FAILED_PRECONDITION for files that do not belong together or of a newer version, DATA_LOSS,
// UNAVAILABLE.
absl::StatusOr<OpenedJournal> OpenJournalFiles(const std::string& folder, const char* vfs,
                                               const std::vector<std::string>& accepted);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_OPENING_H_
