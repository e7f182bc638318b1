#include "server/journal/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

// `pid`: what the file `lock` has; empty if it was removed.
absl::Status FolderInUse(const std::string& folder, const std::string& pid) {
  return absl::FailedPreconditionError(
      absl::StrCat(folder, " is in use by ",
                   pid.empty() ? "another process, and its file `lock` was removed"
                               : absl::StrCat("process ", pid),
                   ": stop that, or take another folder"));
}

std::string PidIn(int file) {
  char pid[32] = {};
  const ssize_t n = pread(file, pid, sizeof(pid) - 1, 0);
  return n > 0 ? std::string(absl::StripAsciiWhitespace(pid)) : std::string();
}

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Take(const std::string& folder) {
  std::error_code error;
  const bool is_new = std::filesystem::create_directories(folder, error);
  // Readable by its owner only. The rights of an existing folder are not changed.
  if (is_new) {
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  }
  if (error) {
    return absl::UnavailableError(absl::StrCat("cannot make ", folder, ": ", error.message()));
  }
  const std::string path = absl::StrCat(folder, "/lock");
  FolderLock lock;
  lock.folder_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // File systems of a network may have no locks of folders: the file's is left then.
  if (lock.folder_ >= 0 && flock(lock.folder_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    lock.file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    return FolderInUse(folder, lock.file_ < 0 ? std::string() : PidIn(lock.file_));
  }
  lock.file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock.file_ < 0) {
    return absl::UnavailableError(absl::StrCat("cannot open ", path, ": ", std::strerror(errno)));
  }
  if (flock(lock.file_, LOCK_EX | LOCK_NB) != 0) return FolderInUse(folder, PidIn(lock.file_));
  // For information only: a failure to write it does not affect the lock.
  const std::string mine = absl::StrCat(getpid(), "\n");
  if (ftruncate(lock.file_, 0) != 0 || pwrite(lock.file_, mine.data(), mine.size(), 0) < 0) {
    return lock;
  }
  return lock;
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : folder_(std::exchange(other.folder_, -1)), file_(std::exchange(other.file_, -1)) {}

FolderLock::~FolderLock() {
  if (file_ >= 0) close(file_);
  if (folder_ >= 0) close(folder_);
}

}  // namespace dynmesh::server
