// Says whether a line of the log that an attacker can bring about is due again. Thread-safe.
#ifndef DYNMESH_SERVER_ACCESS_RARE_LINE_H_
#define DYNMESH_SERVER_ACCESS_RARE_LINE_H_

#include <atomic>
#include <chrono>

namespace dynmesh::server {

class RareLine {
 public:
  using Clock = std::chrono::steady_clock;

  // True at most once in ten seconds.
  bool IsDue() {
    const Clock::rep now = Clock::now().time_since_epoch().count();
    Clock::rep due = due_.load(std::memory_order_relaxed);
    return now >= due && due_.compare_exchange_strong(due, now + kBetween.count());
  }

 private:
  static constexpr Clock::duration kBetween = std::chrono::seconds(10);
  std::atomic<Clock::rep> due_{0};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_RARE_LINE_H_
