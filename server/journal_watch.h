// What is amiss with a server's journal, for the log and for /readyz: it cannot be written, its
// files are gone, or a write hangs. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_WATCH_H_
#define DYNMESH_SERVER_JOURNAL_WATCH_H_

#include <string>

#include "absl/time/time.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

class JournalWatch {
 public:
  // A write that takes longer hangs. A busy disk or database takes less.
  static constexpr absl::Duration kHangs = absl::Seconds(5);

  // The journal outlives it; null: nothing is ever amiss.
  explicit JournalWatch(const Journal* journal) : journal_(journal) {}

  // Logs, once, that a write hangs, and that none does any more. Now and then, by one thread.
  void Look();
  // Empty: nothing is amiss.
  std::string Amiss() const;

 private:
  const Journal* const journal_;
  bool told_ = false;
  absl::Duration longest_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_WATCH_H_
