#include "server/journal/postgres_pool.h"

namespace dynmesh::server::postgres {

void Pool::WaitForRoom(std::unique_lock<std::mutex>& lock) {
  returned_.wait(lock, [this] { return in_use_ < limit_; });
  ++in_use_;
}

absl::StatusOr<Pool::Lease> Pool::Take() {
  std::vector<std::unique_ptr<Session>> stale;  // closed without the lock
  std::unique_lock lock(mutex_);
  WaitForRoom(lock);
  while (!idle_.empty()) {
    std::unique_ptr<Session> session = std::move(idle_.back());
    idle_.pop_back();
    if (!session->IsStale()) return Lease(this, std::move(session));
    stale.push_back(std::move(session));
  }
  lock.unlock();
  return Connect();
}

absl::StatusOr<Pool::Lease> Pool::TakeFresh() {
  std::vector<std::unique_ptr<Session>> closed;
  {
    std::unique_lock lock(mutex_);
    closed.swap(idle_);
    WaitForRoom(lock);
  }
  closed.clear();
  return Connect();
}

absl::StatusOr<Pool::Lease> Pool::Connect() {
  absl::StatusOr<std::unique_ptr<Session>> session =
      Session::Connect(conninfo_, between_statements_);
  if (session.ok()) return Lease(this, *std::move(session));
  Return(nullptr);
  return session.status();
}

void Pool::Return(std::unique_ptr<Session> session) {
  {
    const std::lock_guard lock(mutex_);
    --in_use_;
    if (session != nullptr && session->usable()) idle_.push_back(std::move(session));
  }
  returned_.notify_one();
}

}  // namespace dynmesh::server::postgres
