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
  FolderLock lock(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (lock.file_ < 0) {
    return absl::UnavailableError(absl::StrCat("cannot open ", path, ": ", std::strerror(errno)));
  }
  if (flock(lock.file_, LOCK_EX | LOCK_NB) != 0) {
    char pid[32] = {};
    const ssize_t n = pread(lock.file_, pid, sizeof(pid) - 1, 0);
    const std::string owner(absl::StripAsciiWhitespace(pid));
    return absl::FailedPreconditionError(
        absl::StrCat(folder, " is in use by ",
                     n > 0 && !owner.empty() ? absl::StrCat("process ", owner) : "another process",
                     ": stop that, or take another folder"));
  }
  // For information only: a failure to write it does not affect the lock.
  const std::string mine = absl::StrCat(getpid(), "\n");
  if (ftruncate(lock.file_, 0) != 0 || pwrite(lock.file_, mine.data(), mine.size(), 0) < 0) {
    return lock;
  }
  return lock;
}

FolderLock::FolderLock(FolderLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

FolderLock::~FolderLock() {
  if (file_ >= 0) close(file_);
}

}  // namespace dynmesh::server
