// The reading part of SqliteJournal: each call reads one consistent state on a connection of its
// own.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/journal/journal_errors.h"
#include "server/journal/mesh_reading.h"
#include "server/journal/row_sum.h"
#include "server/journal/sqlite_journal.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;

// Reads a mesh in a transaction. Call Find first, which reads its row; then the others.
class MeshReader {
 public:
  MeshReader(Connection& connection, Journal::Key mesh) : connection_(connection), mesh_(mesh) {}

  absl::Status Find() {
    Statement found(connection_,
                    "SELECT id, description, checksum, snapshot, head FROM meshes WHERE key = ?");
    if (!found.Bind(mesh_).Step()) {
      return found.status().ok() ? NoSuchMesh() : found.status();
    }
    id_ = found.Bytes(0);
    snapshot_ = found.Integer(3);
    head_ = found.Integer(4);
    if (RowSumOf(absl::string_view(id_), absl::string_view(found.Bytes(1))) == found.Integer(2)) {
      return absl::OkStatus();
    }
    return errors().Damaged("the description");
  }

  std::int64_t snapshot() const { return snapshot_; }
  std::int64_t head() const { return head_; }

  ReadingErrors errors() const { return ReadingErrors(id_); }

  // The newest snapshot that is not newer than `revision`.
  absl::StatusOr<std::int64_t> SnapshotBefore(std::uint64_t revision) const {
    Statement base(connection_,
                   "SELECT max(revision) FROM generations WHERE mesh = ? AND revision <= ?");
    if (!base.Bind(mesh_).Bind(static_cast<std::int64_t>(revision)).Step()) return base.status();
    if (base.IsNull(0)) return errors().NotInJournal(revision);
    return base.Integer(0);
  }

  absl::Status Requests(const Journal::Visitor& visitor) const {
    Statement rows(connection_,
                   "SELECT number, id, answer, checksum FROM requests WHERE mesh = ? ORDER BY "
                   "number");
    rows.Bind(mesh_);
    while (rows.Step()) {
      const Journal::Request request{rows.Bytes(1), rows.Bytes(2)};
      if (RowSumOf(mesh_, rows.Integer(0), absl::string_view(request.id),
                   absl::string_view(request.answer)) != rows.Integer(3)) {
        return errors().Damaged(absl::StrCat("the answer to request ", request.id));
      }
      if (absl::Status s = visitor.request(request); !s.ok()) return s;
    }
    return rows.status();
  }

  absl::Status Parts(std::int64_t revision, const Journal::Visitor& visitor) const {
    Statement count(connection_, "SELECT parts FROM generations WHERE mesh = ? AND revision = ?");
    const bool there = count.Bind(mesh_).Bind(revision).Step();
    if (!count.status().ok()) return count.status();
    Statement rows(connection_,
                   "SELECT part, data, checksum FROM snapshots WHERE mesh = ? AND revision = ? "
                   "ORDER BY part");
    rows.Bind(mesh_).Bind(revision);
    std::int64_t parts = 0;
    for (; rows.Step() && rows.Integer(0) == parts; ++parts) {
      const std::string data = rows.Bytes(1);
      if (RowSumOf(mesh_, revision, parts, absl::string_view(data)) != rows.Integer(2)) {
        return errors().Damaged(
            absl::StrCat("part ", parts, " of the snapshot of revision ", revision));
      }
      const auto at = static_cast<std::uint64_t>(revision);
      if (absl::Status s = visitor.snapshot(at, data); !s.ok()) return s;
    }
    if (!rows.status().ok()) return rows.status();
    if (there && parts == count.Integer(0)) return absl::OkStatus();
    return errors().SnapshotIncomplete(revision);
  }

  // All entries in (from, to], in order. With `is_last`, no later one may exist.
  absl::Status Entries(std::int64_t from, std::int64_t to, bool is_last,
                       const Journal::Visitor& visitor) const {
    constexpr std::int64_t kAll = std::numeric_limits<std::int64_t>::max();
    Statement rows(connection_,
                   "SELECT revision, data, checksum FROM entries WHERE mesh = ? AND revision > ? "
                   "AND revision <= ? ORDER BY revision");
    rows.Bind(mesh_).Bind(from).Bind(is_last ? kAll : to);
    std::int64_t last = from;
    while (rows.Step() && rows.Integer(0) == last + 1) {
      const Journal::Entry entry{static_cast<std::uint64_t>(++last), rows.Bytes(1)};
      if (RowSumOf(mesh_, last, absl::string_view(entry.data)) != rows.Integer(2)) {
        return errors().Damaged(absl::StrCat("the entry of revision ", last));
      }
      if (absl::Status s = visitor.entry(entry); !s.ok()) return s;
    }
    if (!rows.status().ok()) return rows.status();
    if (last == to) return absl::OkStatus();
    return errors().EntriesMissing(to);
  }

 private:
  Connection& connection_;
  const Journal::Key mesh_;
  std::string id_;
  std::int64_t snapshot_ = 0, head_ = 0;
};

// An id is not reliable if its row's checksum is invalid.
void NameDamaged(const std::vector<HeadsFile::Head>& recorded,
                 const std::map<std::string, int>& names, std::vector<Journal::Mesh>* meshes) {
  for (Journal::Mesh& mesh : *meshes) {
    if (mesh.damage.ok()) continue;
    FoundMesh found;
    found.head.key = mesh.key;
    found.head.id = mesh.id;
    found.named = false;
    const auto record =
        std::find_if(recorded.begin(), recorded.end(),
                     [&](const HeadsFile::Head& head) { return head.key == mesh.key; });
    mesh.id = SayableName(found, record == recorded.end() ? nullptr : &*record, names);
  }
}

}  // namespace

// In a transaction, so that all reads see one state. If the folder is gone, nothing is made at its
// path, and another journal that stands there is not read.
absl::StatusOr<Connection> SqliteJournal::OpenReader() {
  absl::StatusOr<Connection> reader =
      Connection::Open(path_, options_.vfs, Connection::Missing::kRefuse);
  if (absl::Status gone = presence_.Look(); !gone.ok()) return gone;
  if (!reader.ok()) return reader.status();
  if (absl::Status s = reader->Run("BEGIN"); !s.ok()) return s;
  return reader;
}

absl::StatusOr<std::vector<Journal::Mesh>> SqliteJournal::List() {
  absl::StatusOr<Connection> reader = OpenReader();
  if (!reader.ok()) return reader.status();
  std::vector<Mesh> meshes;
  std::map<std::string, int> names;
  Statement rows(*reader,
                 "SELECT key, id, description, head - snapshot + (snapshot > 0), checksum "
                 "FROM meshes");
  while (rows.Step()) {
    Mesh mesh{rows.Integer(0),  rows.Bytes(1),
              rows.Bytes(2),    static_cast<std::uint64_t>(rows.Integer(3)),
              absl::OkStatus(), absl::OkStatus()};
    ++names[mesh.id];
    if (RowSumOf(absl::string_view(mesh.id), absl::string_view(mesh.description)) !=
        rows.Integer(4)) {
      mesh.damage = ReadingErrors(mesh.id).Damaged("the description");
    }
    meshes.push_back(std::move(mesh));
  }
  if (!rows.status().ok()) return rows.status();
  NameDamaged(heads_->Heads(), names, &meshes);
  AddLosses(&meshes);
  std::sort(meshes.begin(), meshes.end(), [](const Mesh& a, const Mesh& b) { return a.id < b.id; });
  return meshes;
}

void SqliteJournal::AddLosses(std::vector<Mesh>* meshes) {
  for (Mesh& mesh : *meshes) mesh.loss = sealed_.ok() ? CheckWritable(mesh.key) : sealed_;
  const MutexLock lock(losses_mutex_);
  for (const auto& [key, loss] : losses_) {
    if (loss.found.key != 0) continue;
    meshes->push_back({key, loss.name, "", 0, absl::DataLossError(loss.Text()), absl::OkStatus()});
  }
}

absl::Status SqliteJournal::Read(Key mesh, const Visitor& visitor) {
  absl::StatusOr<Connection> connection = OpenReader();
  if (!connection.ok()) return connection.status();
  MeshReader reader(*connection, mesh);
  return ReadNewest(reader, visitor);
}

absl::Status SqliteJournal::ReadPast(Key mesh, std::uint64_t from, std::uint64_t to,
                                     const Visitor& visitor) {
  absl::StatusOr<Connection> connection = OpenReader();
  if (!connection.ok()) return connection.status();
  MeshReader reader(*connection, mesh);
  return ReadRange(reader, from, to, visitor);
}

absl::StatusOr<std::uint64_t> SqliteJournal::Oldest(Key mesh) {
  absl::StatusOr<Connection> reader = OpenReader();
  if (!reader.ok()) return reader.status();
  Statement oldest(*reader, "SELECT min(revision) FROM generations WHERE mesh = ?");
  if (!oldest.Bind(mesh).Step()) return oldest.status();
  if (oldest.IsNull(0)) return NoSuchMesh();
  return static_cast<std::uint64_t>(oldest.Integer(0));
}

}  // namespace dynmesh::server
