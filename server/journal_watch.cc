#include "server/journal_watch.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"

namespace dynmesh::server {

void JournalWatch::Look() {
  if (journal_ == nullptr) return;
  const absl::Duration oldest = journal_->counts().oldest_write;
  const bool hangs = oldest > kHangs;
  if (hangs && !told_) {
    Log(LogLevel::kWarning, "journal_hangs",
        {{"journal", journal_->name()},
         {"seconds", absl::ToInt64Seconds(oldest)},
         {"message",
          "the disk or the database has not answered a write: edits, creations and deletions "
          "wait, reads go on"}});
  } else if (!hangs && told_) {
    Log(LogLevel::kInfo, "journal_answers_again",
        {{"journal", journal_->name()}, {"longest_seconds", absl::ToInt64Seconds(longest_)}});
  }
  longest_ = hangs ? std::max(longest_, oldest) : absl::ZeroDuration();
  told_ = hangs;
}

std::string JournalWatch::Amiss() const {
  if (journal_ == nullptr) return "";
  const Journal::Counts counts = journal_->counts();
  if (counts.gone) {
    return "edits are refused: the data folder is not the one that was opened";
  }
  if (counts.failing) return "edits are refused: the journal cannot be written";
  if (counts.oldest_write <= kHangs) return "";
  return absl::StrCat("edits wait: the journal has not answered a write for ",
                      absl::ToInt64Seconds(counts.oldest_write), " s");
}

}  // namespace dynmesh::server
