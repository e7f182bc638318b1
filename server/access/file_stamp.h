// Files that an operator may replace while the server runs: read whole, and told apart from
// what was read before by a stamp. Pure functions, thread-safe; a stamp costs one stat.
#ifndef DYNMESH_SERVER_ACCESS_FILE_STAMP_H_
#define DYNMESH_SERVER_ACCESS_FILE_STAMP_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

// Equal while the file is the same and was not written to. A file that is not there has one too.
struct FileStamp {
  std::int64_t modified_ns = 0;
  std::uint64_t size = 0;
  std::uint64_t inode = 0;
  friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

FileStamp StampOf(const std::string& path);

// INVALID_ARGUMENT, naming the flag and the file, if it cannot be read or has over 1 MiB.
absl::StatusOr<std::string> ReadSmallFile(const char* flag, const std::string& path);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_FILE_STAMP_H_
