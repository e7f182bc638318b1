#include "server/journal/found_meshes.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "server/journal/row_sum.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;
using RecordedHead = HeadsFile::Head;

absl::StatusOr<std::int64_t> SumOfEntry(Connection& connection, HeadsFile::Key mesh,
                                        std::uint64_t revision, bool* there) {
  Statement entry(connection, "SELECT checksum FROM entries WHERE mesh = ? AND revision = ?");
  *there = entry.Bind(mesh).Bind(static_cast<std::int64_t>(revision)).Step();
  if (!entry.status().ok()) return entry.status();
  return *there ? entry.Integer(0) : 0;
}

absl::Status Complete(Connection& connection,
                      const std::map<HeadsFile::Key, RecordedHead>& recorded, FoundMesh* mesh) {
  RecordedHead& head = mesh->head;
  Statement last(connection, "SELECT ifnull(max(number), 0) FROM requests WHERE mesh = ?");
  last.Bind(head.key).Step();
  if (!last.status().ok()) return last.status();
  head.requests = last.Integer(0);
  bool there = false;
  const auto sum = SumOfEntry(connection, head.key, head.revision, &there);
  if (!sum.ok()) return sum.status();
  head.sum = *sum;
  const auto record = recorded.find(head.key);
  if (record == recorded.end() || record->second.sum == 0) return absl::OkStatus();
  const auto then = SumOfEntry(connection, head.key, record->second.revision, &there);
  if (!then.ok()) return then.status();
  if (there) mesh->sum_on_record = *then;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<FoundMesh>> FindMeshes(Connection& connection,
                                                  const std::vector<RecordedHead>& recorded) {
  std::map<HeadsFile::Key, RecordedHead> heads;
  for (const RecordedHead& head : recorded) heads.emplace(head.key, head);
  std::vector<FoundMesh> meshes;
  {
    Statement rows(connection, "SELECT key, id, head, checksum, description FROM meshes");
    while (rows.Step()) {
      FoundMesh mesh;
      mesh.head.key = rows.Integer(0);
      mesh.head.id = rows.Bytes(1);
      mesh.head.revision = static_cast<std::uint64_t>(rows.Integer(2));
      const std::string description = rows.Bytes(4);
      mesh.named = RowSumOf(absl::string_view(mesh.head.id), absl::string_view(description)) ==
                   rows.Integer(3);
      meshes.push_back(std::move(mesh));
    }
    if (!rows.status().ok()) return rows.status();
  }
  for (FoundMesh& mesh : meshes) {
    if (absl::Status s = Complete(connection, heads, &mesh); !s.ok()) return s;
  }
  return meshes;
}

}  // namespace dynmesh::server
