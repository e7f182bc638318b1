#include "server/journal/past_features.h"

#include "absl/strings/str_cat.h"

namespace dynmesh::server {

absl::Status PastFeatures::AddPart(std::uint64_t revision, const std::string& part) {
  codec::JournalEntry snapshot;
  absl::Status status = codec::DecodeJournalSnapshot(part, dimension_, &snapshot);
  return status.ok() ? Take(revision, snapshot) : status;
}

absl::Status PastFeatures::Apply(const Journal::Entry& entry) {
  const auto batch = codec::DecodeJournalEntry(entry.data, dimension_);
  return batch.ok() ? Take(entry.revision, *batch) : batch.status();
}

absl::Status PastFeatures::Take(std::uint64_t revision, const codec::JournalEntry& entry) {
  if (cancelled_ != nullptr && cancelled_->load(std::memory_order_relaxed)) {
    return absl::CancelledError("the call was cancelled: nothing changed");
  }
  if (absl::Status s = features_.Apply(entry.edits); !s.ok()) {
    return absl::DataLossError(absl::StrCat("revision ", revision, ": ", s.message()));
  }
  revision_ = revision;
  hash_ = entry.hash;
  bits_ = entry.bits;
  return absl::OkStatus();
}

}  // namespace dynmesh::server
