#include "server/journal/mesh_history.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/mesh_data/feature_set.h"
#include "proto/codec/journal_codec.h"
#include "proto/codec/status_codec.h"
#include "server/base/mesh_name.h"
#include "server/revisions/revision_error.h"

namespace dynmesh::server {
namespace {

constexpr char kAdvice[] = "ask for one that is";

// Collects the features from the journal, up to a revision.
class Past {
 public:
  Past(int dimension, const MeshHash& empty, const std::atomic<bool>* cancelled)
      : dimension_(dimension), cancelled_(cancelled), hash_(empty) {}

  absl::Status AddPart(std::uint64_t revision, const std::string& part) {
    codec::JournalEntry snapshot;
    absl::Status status = codec::DecodeJournalSnapshot(part, dimension_, &snapshot);
    return status.ok() ? Take(revision, snapshot) : status;
  }
  absl::Status Apply(const Journal::Entry& entry) {
    const auto batch = codec::DecodeJournalEntry(entry.data, dimension_);
    return batch.ok() ? Take(entry.revision, *batch) : batch.status();
  }
  FeaturesAt Features() const { return {revision_, hash_, features_.Sorted()}; }
  std::uint32_t bits() const { return bits_; }

 private:
  absl::Status Take(std::uint64_t revision, const codec::JournalEntry& entry) {
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

  const int dimension_;
  const std::atomic<bool>* const cancelled_;
  mesh_data::FeatureSet features_;
  std::uint64_t revision_ = 0;
  MeshHash hash_;
  std::uint32_t bits_ = kMeshBits;
};

}  // namespace

absl::StatusOr<FeaturesAt> MeshHistory::At(std::uint64_t revision, const Head& head,
                                           const std::atomic<bool>* cancelled) const {
  absl::StatusOr<Span> span = Between(revision, revision, head, cancelled);
  if (!span.ok()) return span.status();
  return std::move(span->from);
}

absl::StatusOr<MeshHistory::Span> MeshHistory::Between(std::uint64_t from, std::uint64_t to,
                                                       const Head& head,
                                                       const std::atomic<bool>* cancelled) const {
  if (from > head.revision) return FutureRevision(from, head, std::nullopt, kAdvice);
  Past past(dimension_, empty_, cancelled);
  Span span;
  bool begun = false;
  const auto begin = [&] {
    span.from = past.Features();
    span.from_bits = past.bits();
    begun = true;
  };
  Journal::Visitor visitor;
  visitor.snapshot = [&](std::uint64_t r, const std::string& part) {
    return past.AddPart(r, part);
  };
  visitor.entry = [&](const Journal::Entry& entry) {
    if (!begun && entry.revision > from) begin();
    return past.Apply(entry);
  };
  if (absl::Status s = journal_->ReadPast(key_, from, to, visitor); !s.ok()) {
    return ErrorOf(s, from, head);
  }
  if (!begun) begin();
  if (from < to) span.to = past.Features();
  return span;
}

absl::Status MeshHistory::ErrorOf(const absl::Status& status, std::uint64_t revision,
                                  const Head& head) const {
  if (absl::IsCancelled(status)) return status;
  if (absl::IsNotFound(status)) return MeshDeletedError(id_);
  if (absl::IsOutOfRange(status)) {
    const absl::StatusOr<std::uint64_t> oldest = journal_->Oldest(key_);
    if (oldest.ok()) return CompactedRevision(revision, head, *oldest, kAdvice);
    return ErrorOf(oldest.status(), revision, head);
  }
  return MeshError(
      status.code(), codec::reason::kJournalFailed, id_,
      absl::StrCat("cannot be read back at revision ", revision, ": ", status.message()));
}

}  // namespace dynmesh::server
