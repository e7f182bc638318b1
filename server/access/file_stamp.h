// Files that an operator may replace while the server runs: read as a whole; a stamp detects
// changes. Pure functions, thread-safe; a stamp costs one stat.
#ifndef DYNMESH_SERVER_ACCESS_FILE_STAMP_H_
#define DYNMESH_SERVER_ACCESS_FILE_STAMP_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

// Equal while the file is the same and was not written. A missing file has a stamp too.
struct FileStamp {
  std::int64_t modified_ns = 0;
  std::uint64_t size = 0;
  std::uint64_t inode = 0;
  friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

FileStamp StampOf(const std::string& path);

// INVALID_ARGUMENT, naming the flag and the file, if it is unreadable or larger than 1 MiB.
absl::StatusOr<std::string> ReadSmallFile(const char* flag, const std::string& path);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_FILE_STAMP_H_
