#include "server/journal/journal_errors.h"

#include "absl/strings/str_cat.h"
#include "server/base/printable.h"

namespace dynmesh::server {

absl::Status NoSuchMesh() { return absl::NotFoundError("the journal has no such mesh"); }

absl::Status MeshExists(absl::string_view id) {
  return absl::AlreadyExistsError(absl::StrCat("the journal has a mesh ", id, " already"));
}

absl::Status NotTheNextRevision(std::uint64_t revision, std::int64_t last) {
  return absl::FailedPreconditionError(
      absl::StrCat("revision ", revision, " does not follow the journal's ", last));
}

absl::Status NoSnapshotAt(std::uint64_t revision) {
  return absl::FailedPreconditionError(
      absl::StrCat("revision ", revision,
                   " is not between the newest snapshot and the last "
                   "revision of the journal"));
}

absl::Status SnapshotEnded() { return absl::CancelledError("the snapshot is not wanted any more"); }

absl::Status WrittenByAnother(std::uint64_t revision, std::int64_t last) {
  return absl::FailedPreconditionError(
      absl::StrCat("another process writes to this journal: it has revision ", last,
                   " of the mesh, which this server has not made; its next one is ", revision));
}

absl::Status RowsMissing(absl::string_view id) {
  return absl::FailedPreconditionError(
      absl::StrCat("rows of mesh ", Printable(id),
                   " are not there any more: another program uses this journal"));
}

absl::Status ReadingErrors::Damaged(absl::string_view what) const {
  return absl::DataLossError(absl::StrCat("of mesh ", Printable(id_), " ", Printable(what),
                                          " is damaged: its checksum does not fit"));
}

absl::Status ReadingErrors::SnapshotIncomplete(std::int64_t revision) const {
  return absl::DataLossError(absl::StrCat("of mesh ", Printable(id_), " the snapshot of revision ",
                                          revision, ", or a part of it, is missing"));
}

absl::Status ReadingErrors::EntriesMissing(std::int64_t to) const {
  return absl::DataLossError(absl::StrCat("of the revisions of mesh ", Printable(id_), " up to ",
                                          to, " some are missing"));
}

absl::Status ReadingErrors::NotInJournal(std::uint64_t revision) const {
  return absl::OutOfRangeError(
      absl::StrCat("revision ", revision, " of mesh ", Printable(id_), " is not in the journal"));
}

}  // namespace dynmesh::server
