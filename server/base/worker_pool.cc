#include "server/base/worker_pool.h"

#include <algorithm>
#include <utility>

namespace dynmesh::server {
namespace {

// Tasks a strand runs before another strand has its turn: enough to spare the pool's
// lock under load, few enough to be fair.
constexpr int kTurn = 16;

}  // namespace

WorkerPool::WorkerPool(int threads) {
  for (int i = 0; i < std::max(1, threads); ++i) threads_.emplace_back([this] { Run(); });
}

WorkerPool::~WorkerPool() { Stop(); }

void WorkerPool::Post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ && running_ == 0 && tasks_.empty()) return;
    tasks_.push_back(std::move(task));
  }
  wake_.notify_one();
}

void WorkerPool::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void WorkerPool::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    // A running task may post more, so nobody leaves before all are done.
    wake_.wait(lock, [this] { return !tasks_.empty() || (stopping_ && running_ == 0); });
    if (tasks_.empty()) break;
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    ++running_;
    lock.unlock();
    task();
    task = nullptr;  // what it holds is freed outside the lock
    lock.lock();
    --running_;
    if (stopping_) wake_.notify_all();
  }
}

void SerialQueue::Post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    if (scheduled_) return;
    scheduled_ = true;
  }
  Schedule();
}

bool SerialQueue::TryPost(Task task, std::size_t limit) {
  {
    const std::lock_guard lock(mutex_);
    if (tasks_.size() >= limit) return false;
    tasks_.push_back(std::move(task));
    if (scheduled_) return true;
    scheduled_ = true;
  }
  Schedule();
  return true;
}

std::size_t SerialQueue::waiting() const {
  const std::lock_guard lock(mutex_);
  return tasks_.size();
}

void SerialQueue::Schedule() {
  pool_->Post([self = shared_from_this()] { self->Run(); });
}

void SerialQueue::Run() {
  for (int i = 0; i < kTurn; ++i) {
    Task task;
    {
      const std::lock_guard lock(mutex_);
      if (tasks_.empty()) {
        scheduled_ = false;
        return;
      }
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
  Schedule();
}

}  // namespace dynmesh::server
