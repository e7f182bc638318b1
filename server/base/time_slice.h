// Makes long work share its core.
//
// A kernel without preemption lets a thread that has just become ready wait behind a computing
// thread until the next clock tick: up to 4 ms, even if another core becomes idle meanwhile. That
// is longer than most edits take. So long computations call Step often, which yields to others some
// thousand times a second. One thread.
#ifndef DYNMESH_SERVER_BASE_TIME_SLICE_H_
#define DYNMESH_SERVER_BASE_TIME_SLICE_H_

#include <chrono>
#include <thread>

namespace dynmesh::server {

class TimeSlice {
 public:
  // Takes some tens of nanoseconds, plus another thread's turn if one is ready on this core.
  void Step() {
    if (++steps_ % kStepsBetweenLooks != 0 || Clock::now() < end_) return;
    std::this_thread::yield();
    end_ = Clock::now() + kLength;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::microseconds kLength{200};
  static constexpr unsigned kStepsBetweenLooks = 4;

  unsigned steps_ = 0;
  Clock::time_point end_ = Clock::now() + kLength;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_TIME_SLICE_H_
