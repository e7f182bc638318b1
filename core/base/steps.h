// Long work that can be given up between its elementary steps: it counts them, and asks every so
// many whether to stop.
//
// An elementary step is of microseconds: a row, a feature, a point that is inserted. So an answer
// is not more than some milliseconds late. Costs a counter a step. One thread.
#ifndef DYNMESH_CORE_BASE_STEPS_H_
#define DYNMESH_CORE_BASE_STEPS_H_

#include <algorithm>
#include <cstddef>

#include "absl/functional/function_ref.h"

namespace dynmesh {

class Steps {
 public:
  // Most steps between two questions.
  static constexpr std::size_t kBetween = 1024;

  // `stop` outlives this. Once it has said yes it is not asked again.
  explicit Steps(absl::FunctionRef<bool()> stop) : stop_(stop) {}
  Steps(const Steps&) = delete;
  Steps& operator=(const Steps&) = delete;

  // So many steps are about to be taken. Is the work to be given up instead?
  bool Stop(std::size_t count = 1) {
    if (count <= left_ && !stopped_) {
      left_ -= count;
      if (left_ > 0) return false;
    }
    return Ask(count);
  }
  // Has it been given up?
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

// Work that is done whatever happens.
class AllSteps : public Steps {
 public:
  AllSteps() : Steps(&Never) {}

 private:
  static bool Never() { return false; }
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_STEPS_H_
