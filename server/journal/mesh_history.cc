#include "server/journal/mesh_history.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"
#include "server/base/mesh_name.h"
#include "server/journal/past_features.h"
#include "server/revisions/revision_error.h"

namespace dynmesh::server {
namespace {

constexpr char kPastAdvice[] = "ask for one that is";

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
  if (from > head.revision) return FutureRevision(from, head, std::nullopt, kPastAdvice);
  PastFeatures past(dimension_, empty_, cancelled);
  Span span;
  bool begun = false;
  const auto begin = [&] {
    span.from = past.Copy();
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
  if (from < to) span.to = past.Copy();
  return span;
}

absl::Status MeshHistory::ErrorOf(const absl::Status& status, std::uint64_t revision,
                                  const Head& head) const {
  if (absl::IsCancelled(status)) return status;
  if (absl::IsNotFound(status)) return MeshDeletedError(id_);
  if (absl::IsOutOfRange(status)) {
    const absl::StatusOr<std::uint64_t> oldest = journal_->Oldest(key_);
    if (oldest.ok()) return CompactedRevision(revision, head, *oldest, kPastAdvice);
    return ErrorOf(oldest.status(), revision, head);
  }
  return MeshError(
      status.code(), codec::reason::kJournalFailed, id_,
      absl::StrCat("cannot be read back at revision ", revision, ": ", status.message()));
}

}  // namespace dynmesh::server
