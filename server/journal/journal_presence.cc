#include "server/journal/journal_presence.h"

#include <sys/stat.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

constexpr std::chrono::seconds kBetweenLooks{1};

}  // namespace

JournalPresence::JournalPresence(std::string journal, const std::vector<std::string>& files)
    : journal_(std::move(journal)) {
  for (const std::string& path : files) {
    struct stat found = {};
    if (stat(path.c_str(), &found) == 0) files_.push_back({path, found.st_dev, found.st_ino});
  }
  thread_ = std::thread([this] { Run(); });
}

JournalPresence::~JournalPresence() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
  }
  wake_.NotifyAll();
  thread_.join();
}

absl::Status JournalPresence::Find() const {
  for (const File& file : files_) {
    struct stat found = {};
    const bool there = stat(file.path.c_str(), &found) == 0;
    if (there && found.st_dev == file.device && found.st_ino == file.inode) continue;
    return absl::UnavailableError(
        absl::StrCat(file.path,
                     there ? " is another file than the one that is open"
                           : absl::StrCat(" is not there: ", std::strerror(errno)),
                     ". Put the data folder back, or restore it and restart the server"));
  }
  return absl::OkStatus();
}

// One look at a time: an older one must not be told after a newer one.
absl::Status JournalPresence::Look() {
  const MutexLock lock(looking_);
  absl::Status found = Find();
  if (found.ok() == gone_) Tell(found);
  gone_ = !found.ok();
  return found;
}

void JournalPresence::Tell(const absl::Status& found) const {
  if (found.ok()) return Log(LogLevel::kInfo, "journal_back", {{"journal", journal_}});
  Log(LogLevel::kError, "journal_gone",
      {{"journal", journal_},
       {"error", found.message()},
       {"message", "edits are refused until the folder that was opened is at its path again"}});
}

void JournalPresence::Run() {
  MutexLock lock(mutex_);
  while (!wake_.WaitFor(mutex_, kBetweenLooks,
                        [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_; })) {
    lock.Unlock();
    (void)Look();  // what it finds is logged
    lock.Lock();
  }
}

}  // namespace dynmesh::server
