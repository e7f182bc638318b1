#include "server/journal/checkpointer.h"

#include <utility>

#include "server/base/log.h"

namespace dynmesh::server {

Checkpointer::Checkpointer(sqlite::Connection mover)
    : mover_(std::move(mover)), thread_([this] { Run(); }) {}

Checkpointer::~Checkpointer() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Checkpointer::Committed(int log_pages, sqlite::Connection& writer) {
  {
    const std::lock_guard lock(mutex_);
    if (log_pages < log_pages_) due_ = kMany;  // it began anew
    log_pages_ = log_pages;
    if (log_pages < due_) return;
  }
  wake_.notify_one();
  if (log_pages < kFarTooMany) return;
  // Its result is the log's size at the next commit.
  sqlite3_wal_checkpoint_v2(writer.get(), nullptr, SQLITE_CHECKPOINT_RESTART, nullptr, nullptr);
}

void Checkpointer::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || log_pages_ >= due_; });
    if (stopping_) return;
    // Not at each of the next commits again: the writer may be faster, or the disk be full.
    due_ = log_pages_ + kMany;
    lock.unlock();
    const int code = sqlite3_wal_checkpoint_v2(mover_.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                                               nullptr, nullptr);
    if (const absl::Status s = mover_.StatusOf(code, "moving the log"); !s.ok()) {
      Log(LogLevel::kWarning, "checkpoint_failed", {{"error", s.message()}});
    }
    lock.lock();
  }
}

}  // namespace dynmesh::server
