#include "server/journal/checkpointer.h"

#include <utility>

#include "server/base/log.h"

namespace dynmesh::server {
namespace {

// Does not block: the log's pages that readers still use stay, and so does all while the other
// thread moves it.
void MoveLog(const sqlite::Connection& connection) {
  const int code = sqlite3_wal_checkpoint_v2(connection.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                                             nullptr, nullptr);
  if (code == SQLITE_BUSY) return;
  if (const absl::Status s = connection.StatusOf(code, "moving the log"); !s.ok()) {
    Log(LogLevel::kWarning, "checkpoint_failed", {{"error", s.message()}});
  }
}

}  // namespace

Checkpointer::Checkpointer(sqlite::Connection mover)
    : mover_(std::move(mover)), thread_([this] { Run(); }) {}

Checkpointer::~Checkpointer() { Stop(); }

void Checkpointer::Stop() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
  }
  wake_.NotifyAll();
  if (thread_.joinable()) thread_.join();
}

void Checkpointer::KeepLogAtEnd() {
  Stop();
  mover_.MoveLogAtEnd(false);
}

void Checkpointer::Committed(int log_pages, const sqlite::Connection& writer) {
  {
    const MutexLock lock(mutex_);
    if (log_pages < log_pages_) due_ = kMany;  // the log began anew
    log_pages_ = log_pages;
    if (log_pages < due_) return;
    if (log_pages < kFarTooMany) return wake_.NotifyOne();
    due_ = log_pages + kMany;
  }
  MoveLog(writer);
}

void Checkpointer::Run() {
  MutexLock lock(mutex_);
  while (true) {
    wake_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return stopping_ || log_pages_ >= due_;
    });
    if (stopping_) return;
    // Not again at each of the next commits: the writer may be faster than this, or the disk full.
    due_ = log_pages_ + kMany;
    lock.Unlock();
    MoveLog(mover_);
    lock.Lock();
  }
}

}  // namespace dynmesh::server
