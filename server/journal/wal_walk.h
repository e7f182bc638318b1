// Reads SQLite's write-ahead log before SQLite does. SQLite takes the first frame whose checksum
// does not fit for the end of its log: right after a loss of power, when the last transaction was
// on its way, and wrong when a disk or a copy damaged what had been synced. Here the frames after
// that one are looked at, too.
//
// The proof: checksums are a chain, and each frame has its own written in it. A frame that
// continues the one before, which ends a transaction, was written after that transaction had been
// synced. If such a pair stands where SQLite would not come, committed transactions are lost. What
// the last transaction left behind never looks like that: it has one end, and nothing follows. A
// log that was cut shows nothing; that is what HeadsFile is for.
//
// Pure but for reading; O(bytes of the log), about a gigabyte a second.
#ifndef DYNMESH_SERVER_JOURNAL_WAL_WALK_H_
#define DYNMESH_SERVER_JOURNAL_WAL_WALK_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

struct WalWalk {
  std::uint64_t salt = 0;   // of the log's frames; 0: there is no log
  std::uint32_t taken = 0;  // frames up to the last commit that SQLite takes
  std::uint32_t shown = 0;  // frames up to the last one that is known to have been a commit
  bool damaged() const { return shown > taken; }
};

// Of a file that is not there: an empty log. UNAVAILABLE if it cannot be read.
absl::StatusOr<WalWalk> WalkWal(const std::string& path);

// The salt in the header of a log; 0 if there is none.
std::uint64_t WalSalt(const std::string& path);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_WAL_WALK_H_
