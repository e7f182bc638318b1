// Reports progress of a batch to a listener: when a stage begins and ends, and rarely in between.
//
// Keeps the promises of ApplyProgress for any input: totals that grow as operations create others,
// and stages that begin again when a batch is rebuilt. Without a listener a call costs a load; else
// a counter per step and reading the clock every few steps. No decision depends on the clock. One
// batch, one thread.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_PROGRESS_METER_H_
#define DYNMESH_CORE_DYNAMIC_MESH_PROGRESS_METER_H_

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>

#include "dynmesh/dynamic_mesh.h"

namespace dynmesh {

class ProgressMeter {
 public:
  using Stage = ApplyProgress::Stage;
  using Listener = std::function<void(const ApplyProgress&)>;

  // The listener, which may be null, must outlive the meter.
  explicit ProgressMeter(const Listener& listener) : listener_(listener ? &listener : nullptr) {}
  ProgressMeter(const ProgressMeter&) = delete;
  ProgressMeter& operator=(const ProgressMeter&) = delete;

  void Begin(Stage stage) {
    if (listener_ == nullptr) return;
    is_past_ = stage_.has_value() && stage < *stage_;
    if (is_past_ || stage_ == stage) return;
    stage_ = stage;
    done_ = 0;
    part_ = 0;
    Tell(0, 0);
  }

  // Call it before each step of the stage. work() returns the work done and the total known.
  struct Work {
    std::uint64_t done, total;
  };
  template <class WorkNow>
  void Step(WorkNow work) {
    if (listener_ == nullptr) return;
    if (steps_++ % kStepsBetweenLooks != 0 || is_past_ || Clock::now() < next_) return;
    const auto [done, total] = work();
    if (total < done_) return;  // the stage began again with a smaller total
    const auto least = static_cast<std::uint64_t>(std::ceil(part_ * static_cast<double>(total)));
    Tell(std::max({done, done_, std::min(total, least)}), total);
  }

  // Ends the stage, with `all` its work.
  void End(std::uint64_t all = 1) {
    if (listener_ == nullptr || is_past_) return;
    all = std::max({all, done_, std::uint64_t{1}});
    Tell(all, all);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kInterval{50};
  static constexpr std::uint64_t kStepsBetweenLooks = 32;

  void Tell(std::uint64_t done, std::uint64_t total) {
    done_ = done;
    if (total > 0) part_ = static_cast<double>(done) / static_cast<double>(total);
    (*listener_)({*stage_, done, total});
    next_ = Clock::now() + kInterval;
  }

  const Listener* const listener_;
  std::optional<Stage> stage_;  // the latest reported
  bool is_past_ = false;        // the current one is an earlier one
  std::uint64_t steps_ = 0;
  std::uint64_t done_ = 0;  // as last reported
  double part_ = 0;         // done / total as last reported
  Clock::time_point next_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_PROGRESS_METER_H_
