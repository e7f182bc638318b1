// Moves SQLite's log into the database beside the writer. By default SQLite does it within every
// thousandth page's commit, whose caller would wait ten times as long as any other.
//
// What is in the log is durable already, so that nothing hangs on when it is moved, or on whether
// it can be: a log that cannot be moved grows. It begins anew when all of it has been moved and
// nothing was added meanwhile; a writer who never pauses long enough for that moves it himself
// once it has kFarTooMany pages.
#ifndef DYNMESH_SERVER_JOURNAL_CHECKPOINTER_H_
#define DYNMESH_SERVER_JOURNAL_CHECKPOINTER_H_

#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/journal/sqlite.h"

namespace dynmesh::server {

class Checkpointer {
 public:
  static constexpr int kMany = 1'000, kFarTooMany = 4'000;

  // `mover` is a connection of its own to the same database.
  explicit Checkpointer(sqlite::Connection mover);
  ~Checkpointer();

  // After each transaction of `writer`, by whoever writes: the log has so many pages now.
  void Committed(int log_pages, const sqlite::Connection& writer);

 private:
  void Run();

  sqlite::Connection mover_;
  std::mutex mutex_;
  std::condition_variable wake_;
  int log_pages_ = 0;
  int due_ = kMany;  // pages at which the next turn comes
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_CHECKPOINTER_H_
