#include "server/journal/mesh_log.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "proto/codec/journal_codec.h"
#include "server/base/log.h"
#include "server/meshes/mesh_name.h"

namespace dynmesh::server {

MeshLog::MeshLog(Journal* journal, Journal::Key key, std::string id, int dimension,
                 const Sizes& sizes, const Limits& limits)
    : journal_(journal),
      key_(key),
      id_(std::move(id)),
      dimension_(dimension),
      limits_(limits),
      sizes_(sizes) {}

absl::Status MeshLog::Append(const EditBatch& edits, const std::string& request_id,
                             const RequestMemory::Entry& answer) {
  std::optional<Journal::Entry> entry;
  if (answer.from_revision != answer.to_revision) {
    entry = {answer.to_revision, codec::EncodeJournalEntry(edits, answer.hash, dimension_)};
  }
  std::optional<Journal::Request> request;
  if (!request_id.empty()) {
    request = {request_id,
               codec::EncodeJournalAnswer({answer.content.a, answer.content.b, answer.from_revision,
                                           answer.to_revision, answer.hash, answer.work})};
  }
  if (!entry.has_value() && !request.has_value()) return absl::OkStatus();
  if (absl::Status status = journal_->Append(key_, entry, request); !status.ok()) {
    return JournalError(status, id_);
  }
  if (entry.has_value()) sizes_.Add(entry->revision, entry->data.size(), answer.work);
  return absl::OkStatus();
}

bool MeshLog::IsDue(const DynamicMesh& mesh) const {
  if (sizes_.entries < 2 * failed_at_) return false;
  if (sizes_.entries > std::max(limits_.bytes, sizes_.snapshot)) return true;
  return sizes_.operations > limits_.operations && sizes_.operations > 2 * mesh.Stats().operations;
}

void MeshLog::CompactIfDue(const DynamicMesh& mesh) {
  if (!IsDue(mesh)) return;
  const std::vector<std::string> parts =
      codec::EncodeJournalSnapshot(mesh.Features(), mesh.hash(), dimension_);
  if (absl::Status status = journal_->Compact(key_, mesh.revision(), parts); !status.ok()) {
    Log(LogLevel::kWarning, "compact_failed", {{"mesh", id_}, {"error", status.message()}});
    failed_at_ = sizes_.entries;
    return;
  }
  Log(LogLevel::kInfo, "compacted",
      {{"mesh", id_},
       {"revision", mesh.revision()},
       {"entry_bytes", sizes_.entries},
       {"operations", sizes_.operations}});
  sizes_ = {};
  failed_at_ = 0;
  for (const std::string& part : parts) sizes_.snapshot += part.size();
}

}  // namespace dynmesh::server
