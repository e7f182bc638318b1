#include "server/journal/postgres_pool.h"

#include <system_error>

#include "absl/strings/str_cat.h"
#include "core/base/mutex.h"

namespace dynmesh::server::postgres {

// A connection that a thread makes, and for which a caller waits for a while.
struct Pool::Attempt {
  Mutex mutex;
  CondVar ended;
  bool is_over ABSL_GUARDED_BY(mutex) = false;
  bool is_left ABSL_GUARDED_BY(mutex) = false;  // the caller waits no more
  absl::StatusOr<std::unique_ptr<Session>> session ABSL_GUARDED_BY(mutex) =
      absl::UnavailableError("no connection yet");
};

void Pool::WaitForRoom() {
  returned_.Wait(mutex_,
                 [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return in_use_ < limit_; });
  ++in_use_;
}

absl::StatusOr<Pool::Loan> Pool::Take(std::chrono::nanoseconds patience) {
  std::vector<std::unique_ptr<Session>> stale;  // closed without the lock
  MutexLock lock(mutex_);
  WaitForRoom();
  while (!idle_.empty()) {
    std::unique_ptr<Session> session = std::move(idle_.back());
    idle_.pop_back();
    if (!session->IsStale()) return Loan(this, std::move(session));
    stale.push_back(std::move(session));
  }
  lock.Unlock();
  return Connect(patience);
}

absl::StatusOr<Pool::Loan> Pool::TakeFresh(std::chrono::nanoseconds patience) {
  std::vector<std::unique_ptr<Session>> closed;
  {
    const MutexLock lock(mutex_);
    closed.swap(idle_);
    WaitForRoom();
  }
  closed.clear();
  return Connect(patience);
}

absl::StatusOr<Pool::Loan> Pool::Connect(std::chrono::nanoseconds patience) {
  if (patience != kUntilItEnds) return ConnectWithin(patience);
  absl::StatusOr<std::unique_ptr<Session>> session =
      Session::Connect(conninfo_, between_statements_);
  if (session.ok()) return Loan(this, *std::move(session));
  Return(nullptr);
  return session.status();
}

absl::StatusOr<Pool::Loan> Pool::ConnectWithin(std::chrono::nanoseconds patience) {
  const auto attempt = std::make_shared<Attempt>();
  {
    const MutexLock lock(mutex_);
    std::erase_if(attempts_, [](const std::future<void>& other) {
      return other.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    try {
      attempts_.push_back(
          std::async(std::launch::async, [this, attempt] { RunAttempt(*attempt); }));
    } catch (const std::system_error& error) {
      const MutexLock ending(attempt->mutex);
      attempt->is_over = true;
      attempt->session = absl::UnavailableError(absl::StrCat("no thread: ", error.what()));
    }
  }
  absl::Status none;
  {
    const MutexLock lock(attempt->mutex);
    attempt->is_left = !attempt->ended.WaitFor(
        attempt->mutex, patience,
        [&attempt]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(attempt->mutex) { return attempt->is_over; });
    if (!attempt->is_left && attempt->session.ok()) {
      return Loan(this, *std::move(attempt->session));
    }
    none = attempt->is_left
               ? absl::UnavailableError("no connection to the database: it was not made in time")
               : attempt->session.status();
  }
  Return(nullptr);
  return none;
}

void Pool::RunAttempt(Attempt& attempt) {
  absl::StatusOr<std::unique_ptr<Session>> session =
      Session::Connect(conninfo_, between_statements_);
  MutexLock lock(attempt.mutex);
  attempt.is_over = true;
  if (attempt.is_left) {
    lock.Unlock();
    const MutexLock pool_lock(mutex_);
    const bool is_room = in_use_ + static_cast<int>(idle_.size()) < limit_;
    if (session.ok() && is_room) idle_.push_back(*std::move(session));
    return;
  }
  attempt.session = std::move(session);
  attempt.ended.NotifyOne();
}

void Pool::Return(std::unique_ptr<Session> session) {
  {
    const MutexLock lock(mutex_);
    --in_use_;
    if (session != nullptr && session->usable()) idle_.push_back(std::move(session));
  }
  returned_.NotifyOne();
}

}  // namespace dynmesh::server::postgres
