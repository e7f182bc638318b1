#include "server/journal/sqlite_generations.h"

#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "server/journal/row_sum.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;

// A row without bytes has a cost, too.
constexpr std::uint64_t kGenerationRowBytes = 64;

std::uint64_t BytesOf(const std::vector<std::string>& parts) {
  std::uint64_t bytes = 0;
  for (const std::string& part : parts) bytes += part.size();
  return bytes;
}

// Entries of a mesh up to this revision belong to no generation. nullopt: unknown.
absl::StatusOr<std::optional<std::int64_t>> LeftoversUpTo(Connection& connection,
                                                          std::int64_t mesh) {
  Statement found(connection, "SELECT snapshot FROM meshes WHERE key = ?");
  if (!found.Bind(mesh).Step()) {
    if (!found.status().ok()) return found.status();
    return std::numeric_limits<std::int64_t>::max();
  }
  const std::int64_t snapshot = found.Integer(0);
  Statement oldest(connection,
                   "SELECT min(revision), max(revision) FROM generations WHERE mesh = ?");
  if (!oldest.Bind(mesh).Step()) return oldest.status();
  if (oldest.IsNull(0) || oldest.Integer(1) != snapshot) return std::nullopt;
  return oldest.Integer(0);
}

absl::StatusOr<bool> SweepEntries(Connection& connection, std::int64_t mesh, std::int64_t up_to,
                                  std::uint64_t bytes) {
  std::optional<std::int64_t> last;
  {
    Statement rows(connection,
                   "SELECT revision, length(data) FROM entries WHERE mesh = ? AND revision <= ? "
                   "ORDER BY revision");
    rows.Bind(mesh).Bind(up_to);
    for (std::uint64_t seen = 0; seen < bytes && rows.Step();) {
      last = rows.Integer(0);
      seen += static_cast<std::uint64_t>(rows.Integer(1)) + kGenerationRowBytes;
    }
    if (!rows.status().ok()) return rows.status();
  }
  if (!last.has_value()) return false;
  Statement gone(connection, "DELETE FROM entries WHERE mesh = ? AND revision <= ?");
  if (absl::Status s = gone.Bind(mesh).Bind(*last).Finish(); !s.ok()) return s;
  return true;
}

absl::StatusOr<bool> SweepParts(Connection& connection, std::int64_t mesh, std::uint64_t bytes) {
  std::vector<std::pair<std::int64_t, std::int64_t>> found;  // revision and part
  {
    Statement rows(connection,
                   "SELECT revision, part, length(data) FROM snapshots WHERE mesh = ? AND NOT "
                   "EXISTS(SELECT 1 FROM generations AS g WHERE g.mesh = snapshots.mesh AND "
                   "g.revision = snapshots.revision) ORDER BY revision, part");
    rows.Bind(mesh);
    for (std::uint64_t seen = 0; seen < bytes && rows.Step();) {
      found.emplace_back(rows.Integer(0), rows.Integer(1));
      seen += static_cast<std::uint64_t>(rows.Integer(2)) + kGenerationRowBytes;
    }
    if (!rows.status().ok()) return rows.status();
  }
  for (const auto& [revision, part] : found) {
    Statement gone(connection,
                   "DELETE FROM snapshots WHERE mesh = ? AND revision = ? AND part = ?");
    if (absl::Status s = gone.Bind(mesh).Bind(revision).Bind(part).Finish(); !s.ok()) return s;
  }
  return !found.empty();
}

}  // namespace

absl::Status WriteSnapshotPart(Connection& connection, std::int64_t mesh, std::int64_t revision,
                               std::int64_t number, absl::string_view data) {
  Statement insert(connection, "INSERT INTO snapshots VALUES(?, ?, ?, ?, ?)");
  insert.Bind(mesh).Bind(revision).Bind(number).BindBytes(data);
  insert.Bind(RowSumOf(mesh, revision, number, data));
  return insert.Finish();
}

absl::StatusOr<std::size_t> WriteParts(Connection& connection, std::int64_t mesh,
                                       std::int64_t revision, const std::vector<std::string>& parts,
                                       std::size_t first, std::uint64_t bytes) {
  std::size_t part = first;
  for (std::uint64_t written = 0; part < parts.size(); ++part) {
    written += parts[part].size();
    if (part > first && written > bytes) break;
    absl::Status status =
        WriteSnapshotPart(connection, mesh, revision, static_cast<std::int64_t>(part), parts[part]);
    if (!status.ok()) return status;
  }
  return part;
}

absl::Status SwitchOver(Connection& connection, std::int64_t mesh, std::int64_t revision,
                        const std::vector<std::string>& parts, std::uint64_t history_bytes) {
  std::int64_t tail = 0;
  {
    Statement after(connection,
                    "SELECT ifnull(sum(length(data)), 0) FROM entries WHERE mesh = ? AND revision "
                    "> ?");
    if (!after.Bind(mesh).Bind(revision).Step()) return after.status();
    tail = after.Integer(0);
  }
  Statement grown(connection,
                  "UPDATE generations SET bytes = bytes + (SELECT tail_bytes FROM meshes WHERE "
                  "key = mesh) - ? WHERE mesh = ? AND revision = (SELECT snapshot FROM meshes "
                  "WHERE key = mesh)");
  if (absl::Status s = grown.Bind(tail).Bind(mesh).Finish(); !s.ok()) return s;
  std::optional<std::int64_t> dropped;
  {
    Statement older(connection,
                    "SELECT revision, bytes FROM generations WHERE mesh = ? ORDER BY revision "
                    "DESC");
    older.Bind(mesh);
    std::uint64_t bytes = 0;
    for (bool last = true; !dropped.has_value() && older.Step(); last = false) {
      bytes += static_cast<std::uint64_t>(older.Integer(1));
      if (!last && bytes > history_bytes) dropped = older.Integer(0);
    }
    if (!older.status().ok()) return older.status();
  }
  if (dropped.has_value()) {
    Statement gone(connection, "DELETE FROM generations WHERE mesh = ? AND revision <= ?");
    if (absl::Status s = gone.Bind(mesh).Bind(*dropped).Finish(); !s.ok()) return s;
  }
  Statement insert(connection, "INSERT INTO generations VALUES(?, ?, ?, ?)");
  insert.Bind(mesh).Bind(revision).Bind(static_cast<std::int64_t>(parts.size()));
  insert.Bind(static_cast<std::int64_t>(BytesOf(parts)));
  if (absl::Status s = insert.Finish(); !s.ok()) return s;
  Statement newest(connection, "UPDATE meshes SET snapshot = ?, tail_bytes = ? WHERE key = ?");
  return newest.Bind(revision).Bind(tail).Bind(mesh).Finish();
}

absl::StatusOr<bool> SweepPart(Connection& connection, std::int64_t mesh, std::uint64_t bytes) {
  const absl::StatusOr<std::optional<std::int64_t>> up_to = LeftoversUpTo(connection, mesh);
  if (!up_to.ok()) return up_to.status();
  if (!up_to->has_value()) return false;
  const absl::StatusOr<bool> entries = SweepEntries(connection, mesh, **up_to, bytes);
  if (!entries.ok() || *entries) return entries;
  return SweepParts(connection, mesh, bytes);
}

absl::StatusOr<std::vector<std::int64_t>> MeshesWithRows(Connection& connection) {
  std::set<std::int64_t> meshes;
  for (const char* sql : {"SELECT min(mesh) FROM snapshots WHERE mesh > ?",
                          "SELECT min(mesh) FROM entries WHERE mesh > ?"}) {
    // Keys are positive.
    for (std::int64_t after = 0;;) {
      Statement next(connection, sql);
      if (!next.Bind(after).Step()) return next.status();
      if (next.IsNull(0)) break;
      after = next.Integer(0);
      meshes.insert(after);
    }
  }
  return std::vector<std::int64_t>(meshes.begin(), meshes.end());
}

}  // namespace dynmesh::server
