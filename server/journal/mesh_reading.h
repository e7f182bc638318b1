// How a mesh is read, whatever keeps the journal.
#ifndef DYNMESH_SERVER_JOURNAL_MESH_READING_H_
#define DYNMESH_SERVER_JOURNAL_MESH_READING_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

// Journal::Read and ReadPast, by a reader of one mesh in a transaction that sees one state:
//   Find                             reads the mesh's row: NOT_FOUND, DATA_LOSS
//   snapshot, head, errors           of that row
//   SnapshotBefore(revision)         the newest snapshot that is not newer
//   Requests(visitor)
//   Parts(revision, visitor)         of the snapshot at `revision`
//   Entries(from, to, is_last, visitor)   all in (from, to]; if `is_last`, no later one may exist
template <class Reader>
absl::Status ReadNewest(Reader& reader, const Journal::Visitor& visitor) {
  absl::Status status = reader.Find();
  if (status.ok() && visitor.request != nullptr) status = reader.Requests(visitor);
  if (status.ok()) status = reader.Parts(reader.snapshot(), visitor);
  if (!status.ok()) return status;
  return reader.Entries(reader.snapshot(), reader.head(), /*is_last=*/true, visitor);
}
template <class Reader>
absl::Status ReadRange(Reader& reader, std::uint64_t from, std::uint64_t to,
                       const Journal::Visitor& visitor) {
  if (absl::Status s = reader.Find(); !s.ok()) return s;
  if (from > to || to > static_cast<std::uint64_t>(reader.head())) {
    return reader.errors().NotInJournal(to);
  }
  const absl::StatusOr<std::int64_t> base = reader.SnapshotBefore(from);
  if (!base.ok()) return base.status();
  if (absl::Status s = reader.Parts(*base, visitor); !s.ok()) return s;
  return reader.Entries(*base, static_cast<std::int64_t>(to), /*is_last=*/false, visitor);
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_MESH_READING_H_
