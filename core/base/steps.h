// Long work that can be cancelled between its elementary steps: counts steps, and polls a cancel
// function every kBetween steps.
//
// An elementary step takes microseconds: a row, a feature, an inserted point. So cancellation is at
// most some milliseconds late. Costs a counter per step. One thread.
#ifndef DYNMESH_CORE_BASE_STEPS_H_
#define DYNMESH_CORE_BASE_STEPS_H_

#include <algorithm>
#include <cstddef>

#include "absl/functional/function_ref.h"

namespace dynmesh {

class Steps {
 public:
  // The most steps between two polls.
  static constexpr std::size_t kBetween = 1024;

  // `stop` must outlive this. Not called again after it has returned true.
  explicit Steps(absl::FunctionRef<bool()> stop) : stop_(stop) {}
  Steps(const Steps&) = delete;
  Steps& operator=(const Steps&) = delete;

  // Call it before `count` steps. True: cancel the work instead.
  bool Stop(std::size_t count = 1) {
    if (count <= left_ && !stopped_) {
      left_ -= count;
      if (left_ > 0) return false;
    }
    return Ask(count);
  }
  // Has Stop returned true?
  bool stopped() const { return stopped_; }

 private:
  bool Ask(std::size_t count) {
    stopped_ = stopped_ || stop_();
    left_ = kBetween - std::min(count, kBetween);
    return stopped_;
  }

  const absl::FunctionRef<bool()> stop_;
  std::size_t left_ = kBetween;
  bool stopped_ = false;
};

// Steps of work that cannot be cancelled.
class AllSteps : public Steps {
 public:
  AllSteps() : Steps(&Never) {}

 private:
  static bool Never() { return false; }
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_STEPS_H_
