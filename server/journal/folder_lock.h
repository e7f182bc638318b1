// Locks a folder for one process at a time. The lock ends with the process. It is on the folder
// itself, which stays locked if files in it are removed, and on its file `lock`, which has the pid.
#ifndef DYNMESH_SERVER_JOURNAL_FOLDER_LOCK_H_
#define DYNMESH_SERVER_JOURNAL_FOLDER_LOCK_H_

#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

class FolderLock {
 public:
  // Makes the folder if it is missing. FAILED_PRECONDITION, with the pid, if another process (or
  // another lock of this one) has it.
  static absl::StatusOr<FolderLock> Take(const std::string& folder);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  FolderLock() = default;
  int folder_ = -1, file_ = -1;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_FOLDER_LOCK_H_
