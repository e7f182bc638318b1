#include "server/journal/postgres_generations.h"

#include <limits>
#include <optional>

#include "absl/strings/str_cat.h"
#include "server/journal/journal_errors.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server::postgres {
namespace {

// Holds the mesh's row until the end of the transaction. It waits for the other statements here.
constexpr char kHold[] =
    "SELECT snapshot, tail_bytes FROM dynmesh.meshes WHERE key = $1::bigint AND epoch = $2::bigint "
    "AND head >= $3::bigint FOR UPDATE";
// The weakest lock: appends and claims change the row beside it.
constexpr char kHoldEpoch[] =
    "SELECT epoch, snapshot FROM dynmesh.meshes WHERE key = $1::bigint FOR KEY SHARE";

absl::Status NotHeld() {
  return absl::AbortedError("the mesh has another epoch, or not that revision");
}

std::int64_t SumOf(std::int64_t mesh, std::int64_t revision, std::size_t part,
                   const std::string& data) {
  return RowSumOf(mesh, revision, static_cast<std::int64_t>(part), absl::string_view(data));
}

constexpr char kInsertParts[] = R"(
WITH mine AS (
  SELECT key FROM dynmesh.meshes WHERE key = $1::bigint AND epoch = $2::bigint
    AND head >= $3::bigint FOR KEY SHARE)
INSERT INTO dynmesh.snapshots(mesh, revision, part, checksum, data)
SELECT key, $3::bigint, $4::bigint + n - 1, sum, substring($5::bytea FROM start FOR size)
FROM mine, unnest($6::int[], $7::int[], $8::bigint[]) WITH ORDINALITY AS p(start, size, sum, n)
ON CONFLICT (mesh, revision, part) DO UPDATE SET checksum = excluded.checksum, data = excluded.data
RETURNING part)";

// Rows are chosen by their sizes, which are read without the data. A row without bytes costs, too.
constexpr char kSweepEntries[] = R"(
WITH sized AS (
  SELECT revision, sum(length(data) + 64) OVER (ORDER BY revision) - length(data) - 64 AS before
  FROM (SELECT revision, data FROM dynmesh.entries WHERE mesh = $1::bigint
    AND revision <= $2::bigint ORDER BY revision LIMIT 10000) AS oldest),
gone AS (
  DELETE FROM dynmesh.entries AS e USING sized AS s WHERE e.mesh = $1::bigint
    AND e.revision = s.revision AND s.before < $3::bigint RETURNING 1)
SELECT count(*) FROM gone)";
constexpr char kSweepParts[] = R"(
WITH sized AS (
  SELECT revision, part,
    sum(length(data) + 64) OVER (ORDER BY revision, part) - length(data) - 64 AS before
  FROM (SELECT revision, part, data FROM dynmesh.snapshots AS s WHERE mesh = $1::bigint
    AND NOT EXISTS(SELECT 1 FROM dynmesh.generations AS g WHERE g.mesh = s.mesh
      AND g.revision = s.revision) ORDER BY revision, part LIMIT 10000) AS oldest),
gone AS (
  DELETE FROM dynmesh.snapshots AS p USING sized AS s WHERE p.mesh = $1::bigint
    AND p.revision = s.revision AND p.part = s.part AND s.before < $2::bigint RETURNING 1)
SELECT count(*) FROM gone)";
// What a statement that ran beside the deletion has added.
constexpr char kSweepRest[] =
    "WITH g AS (DELETE FROM dynmesh.generations WHERE mesh = $1::bigint) "
    "DELETE FROM dynmesh.requests WHERE mesh = $1::bigint";

// Entries of a mesh up to this revision belong to no generation. nullopt: unknown, or not to be
// touched. Sets `deleted` if the mesh is.
absl::StatusOr<std::optional<std::int64_t>> LeftoversUpTo(Session& session, std::int64_t mesh,
                                                          std::int64_t epoch, bool* deleted) {
  const Answer held = session.Run(kHoldEpoch, mesh);
  if (!held.status.ok()) return held.status;
  *deleted = held.empty();
  if (held.empty()) return std::numeric_limits<std::int64_t>::max();
  if (held.Integer(0, 0) != epoch) return std::nullopt;
  const Answer oldest = session.Run(
      "SELECT min(revision), max(revision) FROM dynmesh.generations WHERE mesh = $1::bigint", mesh);
  if (!oldest.status.ok()) return oldest.status;
  if (oldest.IsNull(0, 0) || oldest.Integer(0, 1) != held.Integer(0, 1)) return std::nullopt;
  return oldest.Integer(0, 0);
}

absl::StatusOr<bool> Sweep(Session& session, std::int64_t mesh, std::int64_t epoch,
                           std::int64_t bytes) {
  bool deleted = false;
  const auto up_to = LeftoversUpTo(session, mesh, epoch, &deleted);
  if (!up_to.ok()) return up_to.status();
  if (!up_to->has_value()) return false;
  Answer swept = session.Run(kSweepEntries, mesh, **up_to, bytes);
  if (!swept.status.ok()) return swept.status;
  if (swept.Integer(0, 0) > 0) return true;
  if (deleted) {
    if (absl::Status s = session.Run(kSweepRest, mesh).status; !s.ok()) return s;
  }
  swept = session.Run(kSweepParts, mesh, bytes);
  if (!swept.status.ok()) return swept.status;
  return swept.Integer(0, 0) > 0;
}

// The first generation, from the newest on, that is too old to be kept.
absl::StatusOr<std::optional<std::int64_t>> Dropped(Session& session, std::int64_t mesh,
                                                    std::uint64_t history_bytes) {
  const Answer older = session.Run(
      "SELECT revision, bytes FROM dynmesh.generations WHERE mesh = $1::bigint ORDER BY revision "
      "DESC",
      mesh);
  if (!older.status.ok()) return older.status;
  std::uint64_t bytes = 0;
  for (std::size_t row = 0; row < older.size(); ++row) {
    bytes += static_cast<std::uint64_t>(older.Integer(row, 1));
    if (row > 0 && bytes > history_bytes) return older.Integer(row, 0);
  }
  return std::nullopt;
}

// The written parts are `parts`, by their checksums.
absl::Status CheckParts(Session& session, std::int64_t mesh, std::int64_t revision,
                        const std::vector<std::string>& parts) {
  const Answer written = session.Run(
      "SELECT part, checksum FROM dynmesh.snapshots WHERE mesh = $1::bigint AND revision = "
      "$2::bigint ORDER BY part",
      mesh, revision);
  if (!written.status.ok()) return written.status;
  bool same = written.size() == parts.size();
  for (std::size_t part = 0; same && part < parts.size(); ++part) {
    same = written.Integer(part, 0) == static_cast<std::int64_t>(part) &&
           written.Integer(part, 1) == SumOf(mesh, revision, part, parts[part]);
  }
  return same ? absl::OkStatus() : absl::UnavailableError("a snapshot was swept away");
}

// In a transaction that holds the mesh's row, which is `held`.
absl::Status Switch(Session& session, std::int64_t mesh, std::int64_t revision, const Answer& held,
                    const std::vector<std::string>& parts, std::uint64_t history_bytes) {
  if (absl::Status s = CheckParts(session, mesh, revision, parts); !s.ok()) return s;
  const Answer after = session.Run(
      "SELECT coalesce(sum(length(data)), 0)::bigint FROM dynmesh.entries WHERE mesh = $1::bigint "
      "AND revision > $2::bigint",
      mesh, revision);
  if (!after.status.ok()) return after.status;
  const std::int64_t tail = after.Integer(0, 0);
  Answer done = session.Run(
      "UPDATE dynmesh.generations SET bytes = bytes + $3::bigint WHERE mesh = $1::bigint AND "
      "revision = $2::bigint",
      mesh, held.Integer(0, 0), held.Integer(0, 1) - tail);
  if (!done.status.ok()) return done.status;
  const auto dropped = Dropped(session, mesh, history_bytes);
  if (!dropped.ok()) return dropped.status();
  done = session.Run(
      "DELETE FROM dynmesh.generations WHERE mesh = $1::bigint AND revision <= $2::bigint", mesh,
      dropped->value_or(-1));
  if (!done.status.ok()) return done.status;
  std::int64_t bytes = 0;
  for (const std::string& part : parts) bytes += static_cast<std::int64_t>(part.size());
  done = session.Run(
      "INSERT INTO dynmesh.generations(mesh, revision, parts, bytes) VALUES($1::bigint, "
      "$2::bigint, "
      "$3::bigint, $4::bigint)",
      mesh, revision, static_cast<std::int64_t>(parts.size()), bytes);
  if (!done.status.ok()) return done.status;
  return session
      .Run(
          "UPDATE dynmesh.meshes SET snapshot = $2::bigint, tail_bytes = $3::bigint WHERE key = "
          "$1::bigint",
          mesh, revision, tail)
      .status;
}

}  // namespace

absl::StatusOr<bool> CheckSnapshot(Session& session, std::int64_t mesh, std::int64_t revision) {
  const Answer found =
      session.Run("SELECT snapshot FROM dynmesh.meshes WHERE key = $1::bigint", mesh);
  if (!found.status.ok()) return found.status;
  if (found.empty()) return NoSuchMesh();
  const std::int64_t snapshot = found.Integer(0, 0);
  if (revision >= snapshot) return revision == snapshot;
  return NoSnapshotAt(static_cast<std::uint64_t>(revision));
}

absl::StatusOr<std::size_t> WriteParts(Session& session, std::int64_t mesh, std::int64_t epoch,
                                       std::int64_t revision, const std::vector<std::string>& parts,
                                       std::size_t first, std::uint64_t bytes) {
  std::string data;
  std::vector<std::int64_t> starts, sizes, sums;
  std::size_t part = first;
  for (; part < parts.size(); ++part) {
    if (part > first && data.size() + parts[part].size() > bytes) break;
    starts.push_back(static_cast<std::int64_t>(data.size()) + 1);
    sizes.push_back(static_cast<std::int64_t>(parts[part].size()));
    sums.push_back(SumOf(mesh, revision, part, parts[part]));
    data += parts[part];
  }
  const Answer written =
      session.Run(kInsertParts, mesh, epoch, revision, static_cast<std::int64_t>(first),
                  Bytes{data}, starts, sizes, sums);
  if (!written.status.ok()) return written.status;
  if (written.size() != sizes.size()) return NotHeld();
  return part;
}

absl::Status SwitchOver(Session& session, std::int64_t mesh, std::int64_t epoch,
                        std::int64_t revision, const std::vector<std::string>& parts,
                        std::uint64_t history_bytes) {
  if (const Answer begun = session.Execute("BEGIN"); !begun.status.ok()) return begun.status;
  const Answer held = session.Run(kHold, mesh, epoch, revision);
  absl::Status status = held.status;
  if (status.ok() && held.empty()) status = NotHeld();
  if (status.ok()) status = Switch(session, mesh, revision, held, parts, history_bytes);
  if (status.ok()) status = session.Execute("COMMIT").status;
  if (!status.ok()) session.Spoil();
  return status;
}

absl::StatusOr<bool> SweepPart(Session& session, std::int64_t mesh, std::int64_t epoch,
                               std::uint64_t bytes) {
  if (const Answer begun = session.Execute("BEGIN"); !begun.status.ok()) return begun.status;
  absl::StatusOr<bool> more = Sweep(session, mesh, epoch, static_cast<std::int64_t>(bytes));
  absl::Status status = more.status();
  if (status.ok()) status = session.Execute("COMMIT").status;
  if (!status.ok()) {
    session.Spoil();
    return status;
  }
  return more;
}

absl::StatusOr<std::vector<std::int64_t>> DeletedMeshes(Session& session) {
  // One search an index entry's mesh, not one a row.
  const Answer found = session.Execute(R"(
WITH RECURSIVE
e(mesh) AS (SELECT min(mesh) FROM dynmesh.entries UNION ALL
  SELECT (SELECT min(mesh) FROM dynmesh.entries WHERE mesh > e.mesh) FROM e
  WHERE e.mesh IS NOT NULL),
s(mesh) AS (SELECT min(mesh) FROM dynmesh.snapshots UNION ALL
  SELECT (SELECT min(mesh) FROM dynmesh.snapshots WHERE mesh > s.mesh) FROM s
  WHERE s.mesh IS NOT NULL)
SELECT mesh FROM (SELECT mesh FROM e UNION SELECT mesh FROM s) AS a
WHERE mesh IS NOT NULL AND NOT EXISTS(SELECT 1 FROM dynmesh.meshes WHERE key = mesh))");
  if (!found.status.ok()) return found.status;
  std::vector<std::int64_t> meshes;
  for (std::size_t row = 0; row < found.size(); ++row) meshes.push_back(found.Integer(row, 0));
  return meshes;
}

}  // namespace dynmesh::server::postgres
