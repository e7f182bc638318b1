// Reads SQLite's write-ahead log before SQLite does. SQLite takes the first frame with a wrong
// checksum for the end of its log. That is right after a loss of power during the last transaction,
// and wrong if a disk or a copy damaged synced data. So the frames after that one are checked, too.
//
// Proof: the checksums form a chain, and each frame stores its own. If a frame continues a frame
// that ends a transaction, it was written after that transaction had been synced. If there is such
// a pair after the first bad frame, committed transactions are lost. The rest of an unfinished last
// transaction never contains such a pair: it has one end, and no frame follows that. A cut log is
// not detected here, but by HeadsFile.
//
// Pure except for reading; O(bytes of the log), about a gigabyte per second.
#ifndef DYNMESH_SERVER_JOURNAL_WAL_WALK_H_
#define DYNMESH_SERVER_JOURNAL_WAL_WALK_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

struct WalWalk {
  std::uint64_t salt = 0;   // of the log's frames; 0: there is no log
  std::uint32_t taken = 0;  // frames up to the last commit that SQLite accepts
  std::uint32_t shown = 0;  // frames up to the last one known to be a commit
  bool damaged() const { return shown > taken; }
};

// A missing file counts as an empty log. UNAVAILABLE if it is unreadable.
absl::StatusOr<WalWalk> WalkWal(const std::string& path);

// The salt in the log's header; 0 if there is none.
std::uint64_t WalSalt(const std::string& path);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_WAL_WALK_H_
