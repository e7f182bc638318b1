#include "server/journal/postgres_keep_alive.h"

namespace dynmesh::server::postgres {

KeepAlive::KeepAlive(Session& session, absl::Duration interval)
    : session_(session), interval_(interval) {
  mutex_.Lock();
  thread_ = std::thread([this] { Run(); });
}

KeepAlive::~KeepAlive() {
  stopping_ = true;
  mutex_.Unlock();
  wake_.NotifyOne();
  thread_.join();
}

absl::Status KeepAlive::While(const std::function<absl::Status()>& work) {
  mutex_.Unlock();
  absl::Status status = work();
  mutex_.Lock();
  return status.ok() ? lost_ : status;
}

// With the mutex only while the reader works on a row: it has it otherwise.
void KeepAlive::Run() {
  const MutexLock lock(mutex_);
  while (!stopping_ && lost_.ok()) {
    wake_.WaitFor(mutex_, absl::ToChronoNanoseconds(interval_),
                  [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_; });
    if (!stopping_) lost_ = session_.Execute("SELECT 1").status;
  }
}

}  // namespace dynmesh::server::postgres
