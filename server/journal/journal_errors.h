// The errors that all journals have in common.
#ifndef DYNMESH_SERVER_JOURNAL_JOURNAL_ERRORS_H_
#define DYNMESH_SERVER_JOURNAL_JOURNAL_ERRORS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

absl::Status NoSuchMesh();                      // NOT_FOUND
absl::Status MeshExists(absl::string_view id);  // ALREADY_EXISTS
// FAILED_PRECONDITION: entries follow the last one; a snapshot is of a revision after the newest
// one's, up to the last.
absl::Status NotTheNextRevision(std::uint64_t revision, std::int64_t last);
absl::Status NoSnapshotAt(std::uint64_t revision);
// The same of a journal that has `revision` already, though this process alone should write it.
absl::Status WrittenByAnother(std::uint64_t revision, std::int64_t last);
// CANCELLED: a snapshot.
absl::Status SnapshotEnded();

// FAILED_PRECONDITION: of a mesh that is copied, rows that were written are not there.
absl::Status RowsMissing(absl::string_view id);

// The errors of reading a mesh with that id.
class ReadingErrors {
 public:
  // The id outlives this.
  explicit ReadingErrors(absl::string_view id) : id_(id) {}

  // DATA_LOSS: the checksum of `what` does not fit.
  absl::Status Damaged(absl::string_view what) const;
  // DATA_LOSS: parts of the snapshot at `revision`; entries up to `to`.
  absl::Status SnapshotIncomplete(std::int64_t revision) const;
  absl::Status EntriesMissing(std::int64_t to) const;
  // OUT_OF_RANGE.
  absl::Status NotInJournal(std::uint64_t revision) const;

 private:
  absl::string_view id_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_JOURNAL_ERRORS_H_
