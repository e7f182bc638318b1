// Threads that run posted tasks in FIFO order, and on top a queue that runs its tasks one at a
// time. Thread-safe. Of the idle threads the last active one is woken: its stack and its part of
// the heap are still in the core's caches.
#ifndef DYNMESH_SERVER_BASE_WORKER_POOL_H_
#define DYNMESH_SERVER_BASE_WORKER_POOL_H_

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/mutex.h"

namespace dynmesh::server {

class WorkerPool {
 public:
  using Task = std::function<void()>;
  // Background threads yield the cores to the other threads of this process.
  enum class Priority { kNormal, kBackground };

  explicit WorkerPool(int threads, Priority priority = Priority::kNormal);
  // As Stop.
  ~WorkerPool();

  // After Stop began, a task from outside the pool is dropped; one posted by a running task still
  // runs.
  void Post(Task task);

  // Runs the queued tasks, then joins. Not to be called by a task of this pool.
  void Stop();

 private:
  struct Idle {
    CondVar wake;
    bool woken = false;  // with the pool's mutex
  };

  void Run();
  void WakeAll() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Mutex mutex_;
  std::vector<Idle*> idle_ ABSL_GUARDED_BY(mutex_);  // as a stack: the most recent is last
  std::deque<Task> tasks_ ABSL_GUARDED_BY(mutex_);
  std::size_t running_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

// The owner of a strand's task, for Withdraw, and the function called in place of the task then.
struct TaskOwner {
  const void* key = nullptr;
  WorkerPool::Task withdrawn;
};

// A strand: its tasks run on the pool in FIFO order, never two at a time, and take turns with the
// other strands of the pool. Tasks may leave work to be done together to OnRest.
//
// A task that has to wait for something else, such as a disk, gives its thread back (Defer): it
// runs again, before all others, once a task of PostFirst says that the time has come.
class SerialQueue : public std::enable_shared_from_this<SerialQueue> {
 public:
  using Task = WorkerPool::Task;
  // What a strand runs before the next strand's turn; the last task is not interrupted. Large
  // enough to spare the pool's lock under load, small enough to be fair.
  struct Turn {
    int tasks = 16;
    std::chrono::steady_clock::duration time = std::chrono::milliseconds(4);
  };

  static std::shared_ptr<SerialQueue> Create(WorkerPool* pool, const Turn& turn) {
    return std::shared_ptr<SerialQueue>(new SerialQueue(pool, turn));
  }
  static std::shared_ptr<SerialQueue> Create(WorkerPool* pool) { return Create(pool, Turn()); }

  void Post(Task task, TaskOwner owner = {});
  // Ahead of all tasks of Post and TryPost, also while they wait for a deferred one. Such tasks run
  // in the order of their posting and cannot be withdrawn.
  void PostFirst(Task task);
  // False, and nothing is posted, if `limit` tasks wait already.
  bool TryPost(Task task, std::size_t limit, TaskOwner owner = {});
  // Removes the waiting tasks of owner `key`, then calls their `withdrawn` on this thread. A
  // running task continues.
  void Withdraw(const void* key);

  // To be called by a running task of Post or TryPost that has done nothing: once it returns, it
  // waits again, and with it all of these tasks, until a task of PostFirst has run; also one that
  // was posted already. Then it is the first to run.
  void Defer() {
    strand_.AssertHeld();
    deferred_ = true;
  }

  // `rest` is called on the strand before it pauses: when no task waits, and before another
  // strand's turn. Call this before the first Post.
  void OnRest(Task rest) { rest_ = std::move(rest); }

  // Number of waiting tasks, without the running one and those of PostFirst.
  std::size_t waiting() const;

 private:
  SerialQueue(WorkerPool* pool, const Turn& turn) : pool_(pool), turn_(turn) {}
  struct Waiting {
    Task task;
    TaskOwner owner;
  };

  void Schedule();
  void Run();
  // Runs a task, and puts it back if it deferred itself.
  void RunOne(Waiting task) ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_);
  // The next task. If there is none and `ends`, the strand is unscheduled.
  std::optional<Waiting> Next(bool ends);

  WorkerPool* const pool_;
  const Turn turn_;
  Task rest_;
  ThreadRole strand_;  // of the running task
  bool deferred_ ABSL_GUARDED_BY(strand_) = false;
  mutable Mutex mutex_;
  std::deque<Waiting> tasks_ ABSL_GUARDED_BY(mutex_);
  std::deque<Task> first_ ABSL_GUARDED_BY(mutex_);
  bool scheduled_ ABSL_GUARDED_BY(mutex_) = false;
  bool blocked_ ABSL_GUARDED_BY(mutex_) = false;  // the first of tasks_ was deferred
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_WORKER_POOL_H_
