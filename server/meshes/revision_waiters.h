// Readers that wait until a mesh is at a revision, each until a time of its own. Thread-safe; calls
// back on the thread of the call that ends the waiting, without a lock.
#ifndef DYNMESH_SERVER_MESHES_REVISION_WAITERS_H_
#define DYNMESH_SERVER_MESHES_REVISION_WAITERS_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/base/mutex.h"

namespace dynmesh::server {

class RevisionWaiters {
 public:
  using Clock = std::chrono::steady_clock;
  using Done = std::function<void(bool reached)>;

  // `done` is called once: with true when Reached tells of `revision` or a later one, with false
  // when Expire tells of `end`, or by Close.
  void Add(std::uint64_t revision, Clock::time_point end, Done done) {
    {
      const MutexLock lock(mutex_);
      if (!closed_) {
        waiting_.emplace(revision, Waiter{end, std::move(done)});
        return;
      }
    }
    done(false);
  }
  void Reached(std::uint64_t revision) {
    Call(true, [revision](std::uint64_t asked, const Waiter&) { return asked <= revision; });
  }
  void Expire(Clock::time_point now) {
    Call(false, [now](std::uint64_t, const Waiter& waiter) { return waiter.end <= now; });
  }
  // Ends all waiting, now and later.
  void Close() {
    {
      const MutexLock lock(mutex_);
      closed_ = true;
    }
    Call(false, [](std::uint64_t, const Waiter&) { return true; });
  }

 private:
  struct Waiter {
    Clock::time_point end;
    Done done;
  };

  template <class IsMeant>
  void Call(bool reached, const IsMeant& is_meant) {
    std::vector<Done> called;
    {
      const MutexLock lock(mutex_);
      for (auto it = waiting_.begin(); it != waiting_.end();) {
        if (!is_meant(it->first, it->second)) {
          ++it;
          continue;
        }
        called.push_back(std::move(it->second.done));
        it = waiting_.erase(it);
      }
    }
    for (const Done& done : called) done(reached);
  }

  Mutex mutex_;
  std::multimap<std::uint64_t, Waiter> waiting_ ABSL_GUARDED_BY(mutex_);  // by revision
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_REVISION_WAITERS_H_
