// Connections to one database for concurrent callers: each has one to itself while it works, up to
// a limit; further callers wait. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_POOL_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_POOL_H_

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

class Pool {
 public:
  // A connection; destroying it gives the connection back.
  class Loan {
   public:
    Loan(Pool* pool, std::unique_ptr<Session> session)
        : pool_(pool), session_(std::move(session)) {}
    Loan(Loan&& other) noexcept
        : pool_(std::exchange(other.pool_, nullptr)), session_(std::move(other.session_)) {}
    Loan& operator=(Loan&&) = delete;
    ~Loan() {
      if (pool_ != nullptr) pool_->Return(std::move(session_));
    }
    Session* operator->() const { return session_.get(); }
    Session& operator*() const { return *session_; }

   private:
    Pool* pool_;
    std::unique_ptr<Session> session_;
  };

  // At most `limit` connections are in use, each made by Session::Connect.
  Pool(std::string conninfo, int limit, absl::Duration between_statements)
      : conninfo_(std::move(conninfo)), limit_(limit), between_statements_(between_statements) {}

  static constexpr std::chrono::nanoseconds kUntilItEnds = std::chrono::nanoseconds::max();

  // An idle connection or a new one. Waits while all are in use. UNAVAILABLE as Session::Connect,
  // and if a new one was not made within `patience`: it is kept for others if it is made later, and
  // does not count as in use meanwhile. With that limit a thread makes it, as the library tries one
  // host after the other.
  absl::StatusOr<Loan> Take(std::chrono::nanoseconds patience = kUntilItEnds);
  // The same, but a new one; and the idle ones, which may be broken as well, are closed.
  absl::StatusOr<Loan> TakeFresh(std::chrono::nanoseconds patience = kUntilItEnds);

 private:
  struct Attempt;

  absl::StatusOr<Loan> Connect(std::chrono::nanoseconds patience);
  absl::StatusOr<Loan> ConnectWithin(std::chrono::nanoseconds patience);
  void RunAttempt(Attempt& attempt);
  void WaitForRoom() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Return(std::unique_ptr<Session> session);

  const std::string conninfo_;
  const int limit_;
  const absl::Duration between_statements_;
  Mutex mutex_;
  CondVar returned_;
  std::vector<std::unique_ptr<Session>> idle_ ABSL_GUARDED_BY(mutex_);
  int in_use_ ABSL_GUARDED_BY(mutex_) = 0;
  // Last: waits for them, and they use the others.
  std::vector<std::future<void>> attempts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_POOL_H_
