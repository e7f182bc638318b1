// What followers of meshes read from PostgreSQL: what came after the revisions that they have, of
// all their meshes at once. At most three statements, however many meshes there are.
// Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_TAILS_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_TAILS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/journal/postgres_session.h"
#include "server/journal/shared_journal.h"

namespace dynmesh::server::postgres {

// As SharedJournal::ReadTails, for the node `node`. Of each mesh at most `bytes` of entries are
// read, but at least one entry. O(meshes + rows).
absl::StatusOr<std::vector<SharedJournal::Tail>> ReadTails(
    Session& session, const std::vector<SharedJournal::Position>& positions,
    const std::string& node, std::int64_t bytes);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_TAILS_H_
