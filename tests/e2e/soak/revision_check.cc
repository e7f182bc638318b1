#include "tests/e2e/soak/revision_check.h"

#include "absl/strings/str_cat.h"

namespace dynmesh::soak {

absl::StatusOr<RevisionCheck::Step> RevisionCheck::Take(const v1::WatchEvent& event) {
  switch (event.event_case()) {
    case v1::WatchEvent::kSnapshot:
      return TakeSnapshot(event.snapshot());
    case v1::WatchEvent::kDiff:
      return TakeDiff(event.diff());
    case v1::WatchEvent::kProgress:
      return TakeProgress(event.progress());
    case v1::WatchEvent::EVENT_NOT_SET:
      break;
  }
  return absl::DataLossError("an event of no kind");
}

void RevisionCheck::EndOfStream() {
  chunk_.reset();
  diff_to_.reset();
}

absl::StatusOr<RevisionCheck::Step> RevisionCheck::TakeSnapshot(const v1::SnapshotChunk& chunk) {
  if (diff_to_.has_value()) return absl::DataLossError("a snapshot begins inside a diff");
  const std::uint32_t expected = chunk_.has_value() ? chunk_->index() + 1 : 0;
  if (chunk.index() != expected) {
    return absl::DataLossError(absl::StrCat("chunk ", chunk.index(), " came for ", expected));
  }
  if (chunk_.has_value() && chunk.revision() != chunk_->revision()) {
    return absl::DataLossError("a snapshot of two revisions");
  }
  if (revision_.has_value() && chunk.revision() <= *revision_) {
    return absl::AlreadyExistsError(
        absl::StrCat("a snapshot of revision ", chunk.revision(), " after ", *revision_));
  }
  if (chunk.more()) {
    chunk_.emplace();
    chunk_->set_index(chunk.index());
    chunk_->set_revision(chunk.revision());
    return Step::kPart;
  }
  chunk_.reset();
  revision_ = chunk.revision();
  hash_ = chunk.hash();
  return Step::kSnapshot;
}

absl::StatusOr<RevisionCheck::Step> RevisionCheck::TakeDiff(const v1::MeshDiff& fragment) {
  if (!revision_.has_value() || chunk_.has_value()) {
    return absl::DataLossError("a diff came before the mesh was there");
  }
  const std::string what = absl::StrCat("a diff from revision ", fragment.from_revision(), " to ",
                                        fragment.to_revision(), " after revision ", *revision_);
  if (fragment.from_revision() > *revision_) return absl::OutOfRangeError(what);
  if (fragment.from_revision() < *revision_) return absl::AlreadyExistsError(what);
  if (fragment.to_revision() <= *revision_) return absl::AlreadyExistsError(what);
  if (diff_to_.has_value() && fragment.to_revision() != *diff_to_) {
    return absl::DataLossError(absl::StrCat(what, ", of which a part led to ", *diff_to_));
  }
  if (fragment.more()) {
    diff_to_ = fragment.to_revision();
    return Step::kPart;
  }
  const bool coalesced = fragment.to_revision() > *revision_ + 1;
  diff_to_.reset();
  revision_ = fragment.to_revision();
  hash_ = fragment.hash();
  return coalesced ? Step::kCoalesced : Step::kRevision;
}

absl::StatusOr<RevisionCheck::Step> RevisionCheck::TakeProgress(
    const v1::Progress& progress) const {
  if (!revision_.has_value() || chunk_.has_value() || diff_to_.has_value()) {
    return absl::DataLossError("progress came inside a revision");
  }
  const std::string what =
      absl::StrCat("progress to revision ", progress.revision(), " after revision ", *revision_);
  if (progress.revision() > *revision_) return absl::OutOfRangeError(what);
  if (progress.revision() < *revision_) return absl::AlreadyExistsError(what);
  if (progress.hash() != hash_) return absl::DataLossError(what + ": another hash");
  return Step::kProgress;
}

}  // namespace dynmesh::soak
