// Moves SQLite's log into the database on its own thread. By default SQLite does this within the
// commit of every thousandth page, which takes ten times as long as other commits.
//
// The log's content is durable already, so correctness does not depend on when it is moved, or on
// success: if it cannot be moved, the log grows. The log begins anew when all of it has been moved
// and nothing was added meanwhile. If the writer never pauses long enough for that, the writer's
// thread moves it once it has kFarTooMany pages.
#ifndef DYNMESH_SERVER_JOURNAL_CHECKPOINTER_H_
#define DYNMESH_SERVER_JOURNAL_CHECKPOINTER_H_

#include <thread>

#include "core/base/mutex.h"
#include "server/journal/sqlite.h"

namespace dynmesh::server {

class Checkpointer {
 public:
  static constexpr int kMany = 1'000, kFarTooMany = 4'000;

  // `mover` is a separate connection to the same database.
  explicit Checkpointer(sqlite::Connection mover);
  ~Checkpointer();

  // To be called by the writing thread after each transaction of `writer`; the log has `log_pages`
  // pages now.
  void Committed(int log_pages, const sqlite::Connection& writer);

  // The log is not moved any more, nor deleted when the connection is closed.
  void KeepLogAtEnd();

 private:
  void Run();
  void Stop();

  sqlite::Connection mover_;
  Mutex mutex_;
  CondVar wake_;
  int log_pages_ ABSL_GUARDED_BY(mutex_) = 0;
  int due_ ABSL_GUARDED_BY(mutex_) = kMany;  // the number of pages at which it is moved next
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_CHECKPOINTER_H_
