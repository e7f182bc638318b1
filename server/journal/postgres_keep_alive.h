// Keeps a transaction open while its reader works on the rows. The database ends a transaction that
// waits too long for its next statement, so that a server that stops in one, or is cut off, does
// not keep its row locks and old rows for ever. A reader that makes a mesh again may compute for
// minutes between two rows; meanwhile a thread of its own sends a statement now and then. Other
// transactions never wait for computations and need none of this.
//
// Thread-compatible: one reader.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_KEEP_ALIVE_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_KEEP_ALIVE_H_

#include <functional>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

class KeepAlive {
 public:
  // `session`, in a transaction, outlives it. Only the caller uses the session, except in While.
  // `interval`: between two statements of the thread.
  KeepAlive(Session& session, absl::Duration interval) ABSL_NO_THREAD_SAFETY_ANALYSIS;
  KeepAlive(const KeepAlive&) = delete;
  KeepAlive& operator=(const KeepAlive&) = delete;
  ~KeepAlive() ABSL_NO_THREAD_SAFETY_ANALYSIS;

  // Calls `work`, which does not use the session, and keeps the transaction meanwhile. The status
  // of `work`, or why the transaction was lost.
  absl::Status While(const std::function<absl::Status()>& work) ABSL_NO_THREAD_SAFETY_ANALYSIS;

 private:
  void Run();

  Session& session_;
  const absl::Duration interval_;
  // For the session. The caller's thread holds it as long as this object lives, but in While: no
  // scope is that long, so the functions of the caller are not checked.
  Mutex mutex_;
  CondVar wake_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status lost_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_KEEP_ALIVE_H_
