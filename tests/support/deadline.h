// Waits that end: after a minute without what they wait for they fail the test, by an exception
// that says what was missing. A whole test has a deadline, too (test_deadline.cc).
#ifndef DYNMESH_TESTS_SUPPORT_DEADLINE_H_
#define DYNMESH_TESTS_SUPPORT_DEADLINE_H_

#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <condition_variable>
#include <future>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

namespace dynmesh::test {

inline constexpr std::chrono::minutes kPatience(1);

[[noreturn]] inline void FailToWait(const std::string& what) {
  throw std::runtime_error("waited a minute in vain: " + what);
}

// Polls until done().
template <class Done>
void WaitUntil(const std::string& what, Done done) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) FailToWait(what);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// The same at each notification.
template <class Done>
void WaitUntil(const std::string& what, std::condition_variable& changed,
               std::unique_lock<std::mutex>& lock, Done done) {
  if (!changed.wait_for(lock, kPatience, done)) FailToWait(what);
}

// The value of the promise.
template <class T>
T WaitFor(const std::string& what, std::promise<T>& promise) {
  std::future<T> value = promise.get_future();
  if (value.wait_for(kPatience) != std::future_status::ready) FailToWait(what);
  return value.get();
}

// The status of the child when it has ended, as of waitpid. One that does not is killed.
inline int WaitForEnd(pid_t child) {
  int status = 0;
  try {
    WaitUntil("the end of process " + std::to_string(child),
              [&] { return waitpid(child, &status, WNOHANG) == child; });
  } catch (const std::runtime_error&) {
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    throw;
  }
  return status;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_DEADLINE_H_
