// Makes long work share its core.
//
// A kernel that is not built to preempt lets a thread that has just become ready wait behind one
// that computes until the next tick of the clock, up to 4 ms, even where another core falls idle
// in the meantime: longer than most edits take in all. So who computes for long calls Step now
// and then, which lets the others have their turn some thousand times a second. One thread.
#ifndef DYNMESH_CORE_BASE_TIME_SLICE_H_
#define DYNMESH_CORE_BASE_TIME_SLICE_H_

#include <chrono>
#include <thread>

namespace dynmesh {

class TimeSlice {
 public:
  // Some tens of nanoseconds; where another thread is ready on this core, its turn.
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

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_TIME_SLICE_H_
