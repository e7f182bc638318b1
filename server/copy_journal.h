// dynmeshd --copy-journal FROM TO: moves meshes between a folder and a database, or between two of
// a kind, while no server uses either (journal_copy.h).
#ifndef DYNMESH_SERVER_COPY_JOURNAL_H_
#define DYNMESH_SERVER_COPY_JOURNAL_H_

#include "absl/status/statusor.h"
#include "server/flags.h"
#include "server/journal/journal_copy.h"

namespace dynmesh::server {

// Opens both journals and copies; the target is made if it is not there. Of the flags it takes
// copy_journal, copy_meshes, and accept_loss for a folder FROM. INVALID_ARGUMENT for bad usage;
// NOT_FOUND if FROM has no journal; FAILED_PRECONDITION if a server uses one of them; else as
// CopyMeshes.
absl::StatusOr<CopyCounts> CopyJournal(const Flags& flags);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_COPY_JOURNAL_H_
