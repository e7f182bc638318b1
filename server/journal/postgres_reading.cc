#include "server/journal/postgres_reading.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/journal/journal_errors.h"
#include "server/journal/mesh_reading.h"
#include "server/journal/postgres_keep_alive.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server::postgres {
namespace {

// At once, of rows of some hundred bytes.
constexpr std::size_t kSmallRows = 2'048;

// Calls `row` for each row of a query, until it returns an error or sets `ended`. In a transaction.
class Rows {
 public:
  // `count`: how many rows are fetched at first.
  Rows(Session& session, const std::string& query, std::size_t count = 8)
      : session_(session), count_(count) {
    status_ = session.Execute(absl::StrCat("DECLARE rows NO SCROLL CURSOR FOR ", query)).status;
  }

  absl::Status ForEach(
      const std::function<absl::Status(const Answer&, std::size_t row, bool* ended)>& visit) {
    bool ended = false;
    while (status_.ok() && !ended) {
      const Answer some = session_.Execute(absl::StrCat("FETCH ", count_, " FROM rows"));
      status_ = some.status;
      if (!status_.ok() || some.empty()) break;
      std::size_t bytes = 0;
      for (std::size_t row = 0; status_.ok() && !ended && row < some.size(); ++row) {
        bytes += some.rows[static_cast<pqxx::result::size_type>(row)].back().size();
        status_ = visit(some, row, &ended);
      }
      // The column with the data is the last. About a megabyte at a time.
      constexpr std::size_t kMost = 4'096, kBytes = 1 << 20;
      count_ =
          bytes < kBytes / 2 ? std::min(kMost, 2 * count_) : std::max<std::size_t>(1, count_ / 2);
    }
    if (status_.ok()) status_ = session_.Execute("CLOSE rows").status;
    return status_;
  }

 private:
  Session& session_;
  absl::Status status_;
  std::size_t count_;
};

// One mesh, in a transaction. Call Find first.
class MeshReader {
 public:
  MeshReader(Session& session, KeepAlive& keeper, Journal::Key mesh)
      : session_(session), keeper_(keeper), mesh_(mesh) {}

  absl::Status Find() {
    const Answer found = session_.Run(
        "SELECT convert_to(id, 'UTF8'), description, checksum, snapshot, head FROM dynmesh.meshes "
        "WHERE key = $1::bigint",
        mesh_);
    if (!found.status.ok()) return found.status;
    if (found.empty()) return NoSuchMesh();
    id_ = found.Bytes(0, 0);
    snapshot_ = found.Integer(0, 3);
    head_ = found.Integer(0, 4);
    const std::string description = found.Bytes(0, 1);
    const bool fits =
        RowSumOf(absl::string_view(id_), absl::string_view(description)) == found.Integer(0, 2);
    return fits ? absl::OkStatus() : errors().Damaged("the description");
  }

  std::int64_t snapshot() const { return snapshot_; }
  std::int64_t head() const { return head_; }

  ReadingErrors errors() const { return ReadingErrors(id_); }

  // The newest snapshot that is not newer than `revision`.
  absl::StatusOr<std::int64_t> SnapshotBefore(std::uint64_t revision) const {
    const Answer base = session_.Run(
        "SELECT max(revision) FROM dynmesh.generations WHERE mesh = $1::bigint AND "
        "revision <= $2::bigint",
        mesh_, static_cast<std::int64_t>(revision));
    if (!base.status.ok()) return base.status;
    if (base.IsNull(0, 0)) return errors().NotInJournal(revision);
    return base.Integer(0, 0);
  }

  absl::Status Requests(const Journal::Visitor& visitor) const {
    Rows rows(session_,
              absl::StrCat("SELECT number, checksum, id, answer FROM dynmesh.requests "
                           "WHERE mesh = ",
                           mesh_, " ORDER BY number"),
              kSmallRows);
    return rows.ForEach([&](const Answer& answer, std::size_t row, bool*) -> absl::Status {
      const Journal::Request request{answer.Bytes(row, 2), answer.Bytes(row, 3)};
      if (RowSumOf(mesh_, answer.Integer(row, 0), absl::string_view(request.id),
                   absl::string_view(request.answer)) != answer.Integer(row, 1)) {
        return errors().Damaged(absl::StrCat("the answer to request ", request.id));
      }
      return keeper_.While([&] { return visitor.request(request); });
    });
  }

  absl::Status Parts(std::int64_t revision, const Journal::Visitor& visitor) const {
    const Answer count = session_.Run(
        "SELECT parts FROM dynmesh.generations WHERE mesh = $1::bigint AND revision = $2::bigint",
        mesh_, revision);
    if (!count.status.ok()) return count.status;
    Rows rows(session_, absl::StrCat("SELECT part, checksum, data FROM dynmesh.snapshots WHERE "
                                     "mesh = ",
                                     mesh_, " AND revision = ", revision, " ORDER BY part"));
    std::int64_t parts = 0;
    const absl::Status status =
        rows.ForEach([&](const Answer& answer, std::size_t row, bool* ended) -> absl::Status {
          *ended = answer.Integer(row, 0) != parts;
          if (*ended) return absl::OkStatus();
          const std::string data = answer.Bytes(row, 2);
          if (RowSumOf(mesh_, revision, parts, absl::string_view(data)) != answer.Integer(row, 1)) {
            return errors().Damaged(
                absl::StrCat("part ", parts, " of the snapshot of revision ", revision));
          }
          ++parts;
          return keeper_.While(
              [&] { return visitor.snapshot(static_cast<std::uint64_t>(revision), data); });
        });
    if (!status.ok()) return status;
    if (!count.empty() && parts == count.Integer(0, 0)) return absl::OkStatus();
    return errors().SnapshotIncomplete(revision);
  }

  // All entries in (from, to], in order. With `is_last`, no later one may exist.
  absl::Status Entries(std::int64_t from, std::int64_t to, bool is_last,
                       const Journal::Visitor& visitor) const {
    std::string query =
        absl::StrCat("SELECT revision, checksum, data FROM dynmesh.entries WHERE mesh = ", mesh_,
                     " AND revision > ", from);
    if (!is_last) absl::StrAppend(&query, " AND revision <= ", to);
    Rows rows(session_, absl::StrCat(query, " ORDER BY revision"));
    std::int64_t last = from;
    const absl::Status status =
        rows.ForEach([&](const Answer& answer, std::size_t row, bool* ended) -> absl::Status {
          *ended = answer.Integer(row, 0) != last + 1;
          if (*ended) return absl::OkStatus();
          const Journal::Entry entry{static_cast<std::uint64_t>(++last), answer.Bytes(row, 2)};
          if (RowSumOf(mesh_, last, absl::string_view(entry.data)) != answer.Integer(row, 1)) {
            return errors().Damaged(absl::StrCat("the entry of revision ", last));
          }
          return keeper_.While([&] { return visitor.entry(entry); });
        });
    if (!status.ok()) return status;
    if (last == to) return absl::OkStatus();
    return errors().EntriesMissing(to);
  }

 private:
  Session& session_;
  KeepAlive& keeper_;
  const Journal::Key mesh_;
  std::string id_;
  std::int64_t snapshot_ = 0, head_ = 0;
};

// Runs `read` in a transaction that sees one state. It has no locks of rows, so it has a limit of
// its own, whatever the lease.
absl::Status InOneState(Session& session, absl::Duration idle,
                        const std::function<absl::Status(KeepAlive&)>& read) {
  const Answer begun =
      session.Execute(absl::StrCat("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY; "
                                   "SET LOCAL idle_in_transaction_session_timeout = ",
                                   absl::ToInt64Milliseconds(idle)));
  if (!begun.status.ok()) return begun.status;
  absl::Status status;
  {
    KeepAlive keeper(session, idle / 4);
    status = read(keeper);
  }
  if (session.usable()) {
    absl::Status ended = session.Execute("ROLLBACK").status;
    if (status.ok()) status = std::move(ended);
  }
  return status;
}

}  // namespace

absl::StatusOr<std::vector<Journal::Mesh>> ListMeshes(Session& session) {
  const Answer rows = session.Execute(
      "SELECT key, convert_to(id, 'UTF8'), description, "
      "head - snapshot + (snapshot > 0)::integer, checksum FROM dynmesh.meshes ORDER BY id");
  if (!rows.status.ok()) return rows.status;
  std::vector<Journal::Mesh> meshes;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    Journal::Mesh mesh{rows.Integer(row, 0), rows.Bytes(row, 1),
                       rows.Bytes(row, 2),   static_cast<std::uint64_t>(rows.Integer(row, 3)),
                       absl::OkStatus(),     absl::OkStatus()};
    if (RowSumOf(absl::string_view(mesh.id), absl::string_view(mesh.description)) !=
        rows.Integer(row, 4)) {
      mesh.damage = ReadingErrors(mesh.id).Damaged("the description");
      mesh.id = absl::StrCat("@", mesh.key);
    }
    meshes.push_back(std::move(mesh));
  }
  std::sort(meshes.begin(), meshes.end(),
            [](const Journal::Mesh& a, const Journal::Mesh& b) { return a.id < b.id; });
  return meshes;
}

absl::Status ReadMesh(Session& session, Journal::Key mesh, absl::Duration idle,
                      const Journal::Visitor& visitor) {
  return InOneState(session, idle, [&](KeepAlive& keeper) {
    MeshReader reader(session, keeper, mesh);
    return ReadNewest(reader, visitor);
  });
}

absl::Status ReadPastOf(Session& session, Journal::Key mesh, absl::Duration idle,
                        std::uint64_t from, std::uint64_t to, const Journal::Visitor& visitor) {
  return InOneState(session, idle, [&](KeepAlive& keeper) {
    MeshReader reader(session, keeper, mesh);
    return ReadRange(reader, from, to, visitor);
  });
}

absl::StatusOr<std::uint64_t> OldestOf(Session& session, Journal::Key mesh) {
  const Answer oldest =
      session.Run("SELECT min(revision) FROM dynmesh.generations WHERE mesh = $1::bigint", mesh);
  if (!oldest.status.ok()) return oldest.status;
  if (oldest.IsNull(0, 0)) return NoSuchMesh();
  return static_cast<std::uint64_t>(oldest.Integer(0, 0));
}

}  // namespace dynmesh::server::postgres
