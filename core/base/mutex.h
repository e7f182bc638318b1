// Locks that the compiler checks. A field says which mutex guards it (ABSL_GUARDED_BY), a function
// which one its caller holds (ABSL_EXCLUSIVE_LOCKS_REQUIRED). Clang then refuses code that does
// otherwise: `-Wthread-safety`, run by tests/source/locks_test.py. Other compilers ignore it.
//
// These are std::mutex and std::condition_variable with the names of capabilities that libstdc++'s
// lack: the same size, cost and code. Not absl::Mutex: Debian's Abseil is not built with
// ThreadSanitizer, which reports a counter under such a lock as a race.
//
//   mutable Mutex mutex_;
//   std::deque<Task> tasks_ ABSL_GUARDED_BY(mutex_);
//
//   const MutexLock lock(mutex_);
//   wake_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !tasks_.empty(); });
//
// A lambda is a function of its own for the check: one that reads guarded fields says so, as above.
// A function that gives the lock up for a while is called with it held, and has it again at its
// end.
#ifndef DYNMESH_CORE_BASE_MUTEX_H_
#define DYNMESH_CORE_BASE_MUTEX_H_

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "absl/base/thread_annotations.h"

namespace dynmesh {

// Not recursive.
class ABSL_LOCKABLE Mutex {
 public:
  Mutex() = default;
  Mutex(const Mutex&) = delete;
  Mutex& operator=(const Mutex&) = delete;

  void Lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { mutex_.lock(); }
  void Unlock() ABSL_UNLOCK_FUNCTION() { mutex_.unlock(); }
  // For the check alone: the caller holds this mutex, under a name that the check does not know.
  void AssertHeld() const ABSL_ASSERT_EXCLUSIVE_LOCK() {}
  // True if it is held now.
  bool TryLock() ABSL_EXCLUSIVE_TRYLOCK_FUNCTION(true) { return mutex_.try_lock(); }

 private:
  friend class CondVar;
  friend class MutexLock;
  std::mutex mutex_;
};

// Holds a mutex until the end of the scope, but for the time between Unlock and Lock.
class ABSL_SCOPED_LOCKABLE MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) ABSL_EXCLUSIVE_LOCK_FUNCTION(mutex) : lock_(mutex.mutex_) {}
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;
  ~MutexLock() ABSL_UNLOCK_FUNCTION() = default;

  void Unlock() ABSL_UNLOCK_FUNCTION() { lock_.unlock(); }
  void Lock() ABSL_EXCLUSIVE_LOCK_FUNCTION() { lock_.lock(); }

 private:
  std::unique_lock<std::mutex> lock_;
};

// What only one thread at a time uses, without a lock, because of how work is handed on: a strand's
// tasks, the thread of an object, the writer under way. Fields are ABSL_GUARDED_BY the role,
// functions require it, and a task that begins to play it says so by AssertHeld. For the check
// alone: nothing is run or waited for.
class ABSL_LOCKABLE ThreadRole {
 public:
  void AssertHeld() const ABSL_ASSERT_EXCLUSIVE_LOCK() {}
};

// The caller of a wait holds the mutex, which is free while it waits. `done` is called with the
// mutex held, so the wait itself is not checked.
class CondVar {
 public:
  void NotifyOne() { changed_.notify_one(); }
  void NotifyAll() { changed_.notify_all(); }

  template <class Done>
  void Wait(Mutex& mutex, Done done)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    Held held(mutex);
    changed_.wait(held.lock, done);
  }
  // What `done` says at the end.
  template <class Duration, class Done>
  bool WaitFor(Mutex& mutex, const Duration& limit, Done done)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    Held held(mutex);
    return changed_.wait_for(held.lock, limit, done);
  }
  template <class Time, class Done>
  bool WaitUntil(Mutex& mutex, const Time& end, Done done)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    Held held(mutex);
    return changed_.wait_until(held.lock, end, done);
  }
  // Until a notification or the end; may end earlier for no reason.
  template <class Time>
  void WaitUntil(Mutex& mutex, const Time& end) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    Held held(mutex);
    changed_.wait_until(held.lock, end);
  }

 private:
  // The caller's hold in the form that std::condition_variable asks for.
  struct Held {
    explicit Held(Mutex& mutex) : lock(mutex.mutex_, std::adopt_lock) {}
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;
    ~Held() { lock.release(); }
    std::unique_lock<std::mutex> lock;
  };

  std::condition_variable changed_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_MUTEX_H_
