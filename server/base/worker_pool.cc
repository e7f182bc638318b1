#include "server/base/worker_pool.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/base/process.h"

namespace dynmesh::server {

WorkerPool::WorkerPool(int threads, Priority priority) {
  for (int i = 0; i < std::max(1, threads); ++i) {
    threads_.emplace_back([this, priority] {
      if (priority == Priority::kBackground) YieldToOtherThreads();
      Run();
    });
  }
}

WorkerPool::~WorkerPool() { Stop(); }

void WorkerPool::Post(Task task) {
  const MutexLock lock(mutex_);
  if (stopping_ && running_ == 0 && tasks_.empty()) return;
  tasks_.push_back(std::move(task));
  if (idle_.empty()) return;
  idle_.back()->woken = true;
  // Under the lock: a woken thread may end, with its Idle, as soon as the lock is free.
  idle_.back()->wake.NotifyOne();
  idle_.pop_back();
}

void WorkerPool::WakeAll() {
  for (Idle* idle : idle_) {
    idle->woken = true;
    idle->wake.NotifyOne();
  }
  idle_.clear();
}

void WorkerPool::Stop() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    WakeAll();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void WorkerPool::Run() {
  Idle self;
  MutexLock lock(mutex_);
  while (true) {
    // A running task may post more, so threads stay until all tasks are done.
    while (tasks_.empty() && !(stopping_ && running_ == 0)) {
      self.woken = false;
      idle_.push_back(&self);
      self.wake.Wait(mutex_,
                     [&self]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return self.woken; });
    }
    if (tasks_.empty()) break;
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    ++running_;
    lock.Unlock();
    task();
    task = nullptr;  // destroyed outside the lock
    lock.Lock();
    --running_;
    if (stopping_) WakeAll();
  }
}

void SerialQueue::Post(Task task, TaskOwner owner) {
  {
    const MutexLock lock(mutex_);
    tasks_.push_back({std::move(task), std::move(owner)});
    if (scheduled_ || blocked_) return;
    scheduled_ = true;
  }
  Schedule();
}

void SerialQueue::PostFirst(Task task) {
  {
    const MutexLock lock(mutex_);
    first_.push_back(std::move(task));
    if (scheduled_) return;
    scheduled_ = true;
  }
  Schedule();
}

bool SerialQueue::TryPost(Task task, std::size_t limit, TaskOwner owner) {
  {
    const MutexLock lock(mutex_);
    if (tasks_.size() >= limit) return false;
    tasks_.push_back({std::move(task), std::move(owner)});
    if (scheduled_ || blocked_) return true;
    scheduled_ = true;
  }
  Schedule();
  return true;
}

void SerialQueue::Withdraw(const void* key) {
  std::vector<Waiting> withdrawn;
  {
    const MutexLock lock(mutex_);
    const auto first = std::stable_partition(
        tasks_.begin(), tasks_.end(), [key](const Waiting& w) { return w.owner.key != key; });
    withdrawn.assign(std::make_move_iterator(first), std::make_move_iterator(tasks_.end()));
    tasks_.erase(first, tasks_.end());
  }
  for (Waiting& waiting : withdrawn) {
    waiting.task = nullptr;
    waiting.owner.withdrawn();
  }
}

std::size_t SerialQueue::waiting() const {
  const MutexLock lock(mutex_);
  return tasks_.size();
}

void SerialQueue::Schedule() {
  pool_->Post([self = shared_from_this()] { self->Run(); });
}

std::optional<SerialQueue::Waiting> SerialQueue::Next(bool ends) {
  const MutexLock lock(mutex_);
  std::optional<Waiting> next;
  if (!first_.empty()) {
    next.emplace(Waiting{std::move(first_.front()), {}});
    first_.pop_front();
    blocked_ = false;  // after it
  } else if (!blocked_ && !tasks_.empty()) {
    next.emplace(std::move(tasks_.front()));
    tasks_.pop_front();
  } else {
    scheduled_ = !ends;
  }
  return next;
}

void SerialQueue::RunOne(Waiting task) {
  task.task();
  if (!deferred_) return;
  deferred_ = false;
  const MutexLock lock(mutex_);
  tasks_.push_front(std::move(task));
  blocked_ = true;
}

void SerialQueue::Run() {
  strand_.AssertHeld();  // scheduled_: once at a time
  const auto end = std::chrono::steady_clock::now() + turn_.time;
  bool rested = true;
  for (int i = 0; i < turn_.tasks; ++i) {
    std::optional<Waiting> next = Next(rested);
    if (!next.has_value() && !rested) {
      rest_();
      rested = true;
      next = Next(rested);  // a task may have been posted meanwhile
    }
    if (!next.has_value()) return;
    RunOne(*std::move(next));
    rested = rest_ == nullptr;
    if (std::chrono::steady_clock::now() >= end) break;
  }
  if (!rested) rest_();
  Schedule();
}

}  // namespace dynmesh::server
