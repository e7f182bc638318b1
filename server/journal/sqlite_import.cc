// The part of SqliteJournal that takes meshes from other journals. Rows of a key without a mesh are
// leftovers (sqlite_generations.h) until Publish makes the mesh.
#include <utility>

#include "server/journal/journal_errors.h"
#include "server/journal/row_sum.h"
#include "server/journal/sqlite_generations.h"
#include "server/journal/sqlite_journal.h"

namespace dynmesh::server {

using sqlite::Statement;

// A row that comes and goes in one transaction: its key is not given again.
absl::StatusOr<Journal::Key> SqliteJournal::NewKey() {
  Key key = 0;
  const absl::Status status = Write([&]() -> absl::Status {
    const absl::StatusOr<Key> made = InsertMesh("", "");
    if (!made.ok()) return made.status();
    key = *made;
    return Run("DELETE FROM meshes WHERE key = ?", key);
  });
  if (!status.ok()) return status;
  return key;
}

absl::Status SqliteJournal::WriteUnseen(Key mesh, const std::vector<Part>& parts,
                                        const std::vector<Entry>& entries) {
  return Write([&]() -> absl::Status {
    for (const Part& part : parts) {
      const auto revision = static_cast<std::int64_t>(part.revision);
      absl::Status s = WriteSnapshotPart(writer_, mesh, revision, part.number, part.data);
      if (!s.ok()) return s;
    }
    for (const Entry& entry : entries) {
      if (absl::Status s = InsertEntry(mesh, entry).status(); !s.ok()) return s;
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<std::int64_t> SqliteJournal::CountOf(const char* sql, Key mesh) {
  Statement count(writer_, sql);
  if (!count.Bind(mesh).Step()) return count.status();
  return count.Integer(0);
}

absl::Status SqliteJournal::Publish(Key mesh, const Whole& whole) {
  return Write([&]() -> absl::Status {
    if (absl::Status s = CheckNew(whole.id); !s.ok()) return s;
    const auto entries = CountOf("SELECT count(*) FROM entries WHERE mesh = ?", mesh);
    if (!entries.ok()) return entries.status();
    const auto parts = CountOf("SELECT count(*) FROM snapshots WHERE mesh = ?", mesh);
    if (!parts.ok()) return parts.status();
    if (*entries != static_cast<std::int64_t>(whole.entries()) ||
        *parts != static_cast<std::int64_t>(whole.parts())) {
      return RowsMissing(whole.id);
    }
    return InsertWhole(mesh, whole);
  });
}

absl::Status SqliteJournal::InsertWhole(Key mesh, const Whole& whole) {
  const Generation& newest = whole.generations.back();
  const auto head = static_cast<std::int64_t>(whole.head);
  {
    Statement insert(writer_,
                     "INSERT INTO meshes(key, id, description, snapshot, head, tail_bytes, "
                     "checksum) VALUES(?, ?, ?, ?, ?, ?, ?)");
    insert.Bind(mesh).BindText(whole.id).BindBytes(whole.description);
    insert.Bind(static_cast<std::int64_t>(newest.revision)).Bind(head);
    insert.Bind(static_cast<std::int64_t>(newest.entry_bytes));
    insert.Bind(RowSumOf(absl::string_view(whole.id), absl::string_view(whole.description)));
    if (absl::Status s = insert.Finish(); !s.ok()) return s;
  }
  for (const Generation& generation : whole.generations) {
    // The newest one's entries are counted in the mesh's row.
    const std::uint64_t bytes =
        generation.snapshot_bytes + (&generation == &newest ? 0 : generation.entry_bytes);
    Statement insert(writer_, "INSERT INTO generations VALUES(?, ?, ?, ?)");
    insert.Bind(mesh).Bind(static_cast<std::int64_t>(generation.revision));
    insert.Bind(static_cast<std::int64_t>(generation.parts)).Bind(static_cast<std::int64_t>(bytes));
    if (absl::Status s = insert.Finish(); !s.ok()) return s;
  }
  std::int64_t number = 0;
  for (const Request& request : whole.requests) {
    if (absl::Status s = InsertRequest(mesh, ++number, request); !s.ok()) return s;
  }
  Statement last(writer_, "SELECT checksum FROM entries WHERE mesh = ? AND revision = ?");
  const bool there = last.Bind(mesh).Bind(head).Step();
  if (!last.status().ok()) return last.status();
  heads_->Stage(
      {mesh, whole.id, whole.head, there ? last.Integer(0) : 0, number, HeadsFile::State::kThere});
  return absl::OkStatus();
}

}  // namespace dynmesh::server
