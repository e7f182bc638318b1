// Reads all that a journal has of a mesh, not only its newest generation, through the interface of
// journals. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_WHOLE_READING_H_
#define DYNMESH_SERVER_JOURNAL_WHOLE_READING_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

// The revisions at which its generations begin, the oldest first. O(generations) short reads.
absl::StatusOr<std::vector<std::uint64_t>> GenerationsOf(Journal& journal, Journal::Key mesh);

// Visits the generations from the oldest on: of each its snapshot, unless it is that of revision 0,
// and its entries; requests come before the newest. Several reads: nothing may write to the mesh
// meanwhile. Errors as Journal::Read.
absl::Status ReadWhole(Journal& journal, Journal::Key mesh,
                       const std::vector<std::uint64_t>& generations,
                       const Journal::Visitor& visitor);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_WHOLE_READING_H_
