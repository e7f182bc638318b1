#include "server/journal/postgres_keep_alive.h"

namespace dynmesh::server::postgres {

KeepAlive::KeepAlive(Session& session, absl::Duration interval)
    : session_(session), interval_(interval), reading_(mutex_), thread_([this] { Run(); }) {}

KeepAlive::~KeepAlive() {
  stopping_ = true;
  reading_.unlock();
  wake_.notify_one();
  thread_.join();
}

absl::Status KeepAlive::While(const std::function<absl::Status()>& work) {
  reading_.unlock();
  absl::Status status = work();
  reading_.lock();
  return status.ok() ? lost_ : status;
}

// With the mutex only while the reader works on a row: it has it otherwise.
void KeepAlive::Run() {
  std::unique_lock lock(mutex_);
  while (!stopping_ && lost_.ok()) {
    wake_.wait_for(lock, absl::ToChronoNanoseconds(interval_));
    if (!stopping_) lost_ = session_.Execute("SELECT 1").status;
  }
}

}  // namespace dynmesh::server::postgres
