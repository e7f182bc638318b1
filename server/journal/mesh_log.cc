#include "server/journal/mesh_log.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "proto/codec/journal_codec.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"

namespace dynmesh::server {

MeshLog::MeshLog(Journal* journal, Journal::Key key, std::string id, int dimension,
                 const Sizes& sizes, const Limits& limits)
    : journal_(journal),
      key_(key),
      id_(std::move(id)),
      dimension_(dimension),
      limits_(limits),
      sizes_(sizes) {}

absl::Status MeshLog::Append(std::span<const Batch> batches) {
  std::vector<Journal::Entry> entries;
  std::vector<Journal::Request> requests;
  Sizes sizes = sizes_;
  for (const Batch& batch : batches) {
    const RequestMemory::Entry& answer = batch.answer;
    if (answer.from_revision != answer.to_revision) {
      entries.push_back(
          {answer.to_revision, codec::EncodeJournalEntry(*batch.edits, answer.hash, dimension_)});
      sizes.Add(answer.to_revision, entries.back().data.size(), answer.work);
    }
    if (!batch.request_id.empty()) {
      requests.push_back(
          {std::string(batch.request_id),
           codec::EncodeJournalAnswer({answer.content.a, answer.content.b, answer.from_revision,
                                       answer.to_revision, answer.hash, answer.work})});
    }
  }
  if (entries.empty() && requests.empty()) return absl::OkStatus();
  if (absl::Status status = journal_->Append(key_, entries, requests); !status.ok()) {
    owns_ = OutcomeOf(status) == AppendOutcome::kRefused;
    return JournalError(status, id_);
  }
  sizes_ = sizes;
  return absl::OkStatus();
}

bool MeshLog::IsDue(const DynamicMesh& mesh) const {
  if (sizes_.entries < 2 * failed_at_) return false;
  if (sizes_.entries > std::max(limits_.bytes, sizes_.snapshot)) return true;
  return sizes_.operations > limits_.operations && sizes_.operations > 2 * mesh.Stats().operations;
}

void MeshLog::CompactIfDue(const DynamicMesh& mesh) {
  if (IsDue(mesh)) Compact(mesh);
}

absl::Status MeshLog::AppendOtherBits(const DynamicMesh& mesh) {
  const EditBatch none;
  Batch batch;
  batch.edits = &none;
  batch.answer.from_revision = mesh.revision() - 1;
  batch.answer.to_revision = mesh.revision();
  batch.answer.hash = mesh.hash();
  if (absl::Status status = Append({&batch, 1}); !status.ok()) return status;
  Compact(mesh);
  return absl::OkStatus();
}

void MeshLog::Compact(const DynamicMesh& mesh) {
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
