// Keeps a transaction open while its reader works on the rows. The database ends a transaction that
// waits too long for its next statement, so that a server that stops in one, or is cut off, does
// not keep its row locks and old rows for ever. A reader that makes a mesh again may compute for
// minutes between two rows; meanwhile a thread of its own sends a statement now and then. Other
// transactions never wait for computations and need none of this.
//
// Thread-compatible: one reader.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_KEEP_ALIVE_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_KEEP_ALIVE_H_

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

class KeepAlive {
 public:
  // `session`, in a transaction, outlives it. Only the caller uses the session, except in While.
  // `interval`: between two statements of the thread.
  KeepAlive(Session& session, absl::Duration interval);
  KeepAlive(const KeepAlive&) = delete;
  KeepAlive& operator=(const KeepAlive&) = delete;
  ~KeepAlive();

  // Calls `work`, which does not use the session, and keeps the transaction meanwhile. The status
  // of `work`, or why the transaction was lost.
  absl::Status While(const std::function<absl::Status()>& work);

 private:
  void Run();

  Session& session_;
  const absl::Duration interval_;
  std::mutex mutex_;
  std::unique_lock<std::mutex> reading_;  // the caller's hold on the session
  std::condition_variable wake_;
  bool stopping_ = false;
  absl::Status lost_;
  std::thread thread_;
};

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_KEEP_ALIVE_H_
