// That locks keep threads apart is shown by ThreadSanitizer over all other tests; what the compiler
// checks by tests/source/locks_test.py.
#include "core/base/mutex.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace dynmesh::mutex_test {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

// Whether another thread could have the mutex now.
bool IsFree(Mutex& mutex) {
  bool free = false;
  std::thread([&] {
    free = mutex.TryLock();
    if (free) mutex.Unlock();
  }).join();
  return free;
}

TEST(MutexTest, ALockEndsWithItsScope) {
  Mutex mutex;
  {
    const MutexLock lock(mutex);
    EXPECT_FALSE(IsFree(mutex));
  }
  EXPECT_TRUE(IsFree(mutex));
}

TEST(MutexTest, ALockMayEndEarlierAndBeginAgain) {
  Mutex mutex;
  {
    MutexLock lock(mutex);
    lock.Unlock();
    EXPECT_TRUE(IsFree(mutex));
    lock.Lock();
    EXPECT_FALSE(IsFree(mutex));
    lock.Unlock();
  }
  EXPECT_TRUE(IsFree(mutex));
}

TEST(MutexTest, AWaitGivesTheMutexUpAndHasItAgain) {
  Mutex mutex;
  CondVar changed;
  bool done = false;
  std::thread other;
  {
    const MutexLock lock(mutex);
    other = std::thread([&] {
      const MutexLock theirs(mutex);  // the wait has begun, or this one would not get it
      done = true;
      changed.NotifyOne();
    });
    changed.Wait(mutex, [&] { return done; });
    EXPECT_TRUE(done);
    EXPECT_FALSE(IsFree(mutex));
  }
  other.join();
  EXPECT_TRUE(IsFree(mutex));
}

TEST(MutexTest, AWaitWithALimitSaysHowItEnded) {
  Mutex mutex;
  CondVar changed;
  const MutexLock lock(mutex);
  const auto past = std::chrono::steady_clock::now() - milliseconds(1);
  EXPECT_FALSE(changed.WaitFor(mutex, milliseconds(1), [] { return false; }));
  EXPECT_FALSE(changed.WaitUntil(mutex, past, [] { return false; }));
  EXPECT_TRUE(changed.WaitFor(mutex, hours(1), [] { return true; }));
  EXPECT_TRUE(changed.WaitUntil(mutex, past + hours(1), [] { return true; }));
  changed.WaitUntil(mutex, past);
  EXPECT_FALSE(IsFree(mutex));
}

}  // namespace
}  // namespace dynmesh::mutex_test
