// Threads that run posted tasks, first come first served, and a queue on top that
// runs its tasks one at a time. Thread-safe. Of idle threads the one that worked last is woken:
// its stack and its part of the heap are still in the core's caches.
#ifndef DYNMESH_SERVER_BASE_WORKER_POOL_H_
#define DYNMESH_SERVER_BASE_WORKER_POOL_H_

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace dynmesh::server {

class WorkerPool {
 public:
  using Task = std::function<void()>;
  // Background threads yield the cores to the others of this process.
  enum class Priority { kNormal, kBackground };

  explicit WorkerPool(int threads, Priority priority = Priority::kNormal);
  // As Stop.
  ~WorkerPool();

  // After Stop began a task from outside the pool is dropped; one posted by a running
  // task still runs.
  void Post(Task task);

  // Runs what is queued, then joins. Not from a task of this pool.
  void Stop();

 private:
  struct Idle {
    std::condition_variable wake;
    bool woken = false;
  };

  void Run();
  void WakeAll();

  std::mutex mutex_;
  std::vector<Idle*> idle_;  // the last to become idle is the last
  std::deque<Task> tasks_;
  std::size_t running_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

// Whose a task of a strand is, if its owner may want it back, and what is done in its place then.
struct TaskOwner {
  const void* key = nullptr;
  WorkerPool::Task withdrawn;
};

// A strand: tasks run on the pool in the order posted, never two at a time, and take
// turns with the other strands of the pool. Tasks may leave work to be done together: `rest`.
class SerialQueue : public std::enable_shared_from_this<SerialQueue> {
 public:
  using Task = WorkerPool::Task;
  // What a strand runs before another one has its turn, the last task whole: enough to spare the
  // pool's lock under load, little enough to be fair.
  struct Turn {
    int tasks = 16;
    std::chrono::steady_clock::duration time = std::chrono::milliseconds(4);
  };

  static std::shared_ptr<SerialQueue> Create(WorkerPool* pool, const Turn& turn) {
    return std::shared_ptr<SerialQueue>(new SerialQueue(pool, turn));
  }
  static std::shared_ptr<SerialQueue> Create(WorkerPool* pool) { return Create(pool, Turn()); }

  void Post(Task task, TaskOwner owner = {});
  // False, and nothing posted, if `limit` tasks wait already.
  bool TryPost(Task task, std::size_t limit, TaskOwner owner = {});
  // Takes out the owner's tasks that wait, makes room for others, then calls their `withdrawn`, on
  // this thread. One that has begun goes on.
  void Withdraw(const void* key);

  // Called on the strand before it pauses: when no task waits, and before others have their turn.
  // To be given before the first task.
  void OnRest(Task rest) { rest_ = std::move(rest); }

  // Tasks that wait; the one that runs not counted.
  std::size_t waiting() const;

 private:
  SerialQueue(WorkerPool* pool, const Turn& turn) : pool_(pool), turn_(turn) {}
  struct Waiting {
    Task task;
    TaskOwner owner;
  };

  void Schedule();
  void Run();
  // The next task; without one that was the strand's last if `ends`.
  std::optional<Waiting> Next(bool ends);

  WorkerPool* const pool_;
  const Turn turn_;
  Task rest_;
  mutable std::mutex mutex_;
  std::deque<Waiting> tasks_;
  bool scheduled_ = false;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_WORKER_POOL_H_
