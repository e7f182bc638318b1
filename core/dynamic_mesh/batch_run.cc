#include "core/dynamic_mesh/batch_run.h"

#include <utility>

#include "core/base/steps.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/stopwatch.h"
#include "core/plc/messages.h"

namespace dynmesh {
namespace {

// An operation of kNearest takes a third of the time of another: measured with uniform points and
// segments. Progress counts thirds that are left out of `operations`, `nearest` of which are such.
std::uint64_t Weighed(std::uint64_t operations, std::uint64_t nearest) {
  return operations - nearest / 3 * 2;
}

// A propagation holds new and obsolete vertices at once: so many are allowed during it.
std::uint64_t MostVerticesOnTheWay(const Limits& limits) {
  return limits.max_vertices + limits.max_vertices / 8 + 64;
}

}  // namespace

template <int D>
Ended BatchRun<D>::Propagate(MeshState<D>& state, Plan plan) {
  const bool is_fresh = plan == Plan::kRebuild;
  auto& refinement = state.refinement;
  const auto& engine = refinement.engine();
  const sac::Counters& counters = engine.counters();
  const std::uint64_t nearest_before = refinement.nearest_run();
  std::uint64_t taken = 0;
  const auto work = [&] {
    const std::uint64_t done = Weighed(taken, refinement.nearest_run() - nearest_before);
    const std::uint64_t waiting =
        Weighed(engine.waiting(), engine.waiting_in(meshing::NearestEpoch()));
    return ProgressMeter::Work{done, done + waiting};
  };
  const std::uint64_t most_vertices =
      is_fresh ? options.limits.max_vertices : MostVerticesOnTheWay(options.limits);
  PropagationCost cost(tuning.rebuild, D, engine);
  const auto reason_to_stop = [&] {
    if (IsOverLimits(refinement, most_vertices)) return Ended::kOverLimits;
    if (executed + counters.executed > most_operations) return Ended::kOverWork;
    const bool may_build =
        executed + counters.executed + engine.operation_count() <= most_operations;
    if (is_fresh || !may_build) return Ended::kDone;
    const bool is_stale = plan == Plan::kProbe && cost.IsMostlyStale();
    return is_stale || cost.IsTooDear() ? Ended::kTooDear : Ended::kDone;
  };
  Ended ended = Ended::kDone;
  const bool done = refinement.Propagate([&] {
    meter.Step(work);
    ++taken;
    ended = interrupt() ? Ended::kCancelled : reason_to_stop();
    return ended != Ended::kDone;
  });
  if (done) {
    ended = reason_to_stop();
    if (ended == Ended::kTooDear) ended = Ended::kDone;
  }
  // The engine's capacity is exceeded.
  if (!done && ended == Ended::kDone) ended = Ended::kOverLimits;
  if (ended == Ended::kDone) meter.End(work().done);
  executed += counters.executed;
  return ended;
}

template <int D>
absl::Status BatchRun<D>::StatusOf(Ended ended, const MeshState<D>& state) const {
  switch (ended) {
    case Ended::kCancelled:
      return plc::InterruptedError();
    case Ended::kOverWork:
      return WorkLimitError(most_operations);
    default:
      return LimitsStatus(state.refinement, options);
  }
}

template <int D>
absl::StatusOr<Built<D>> BatchRun<D>::Build(const plc::Delta<D>& all, std::size_t features) {
  Built<D> built{std::make_unique<MeshState<D>>(options, tuning), {}, 0};
  MeshState<D>& fresh = *built.state;
  fresh.refinement.Reserve(features);
  meter.Begin(ApplyProgress::Stage::kRefine);
  Steps steps(interrupt);
  fresh.features.Apply(all, fresh.refinement, steps);
  if (steps.stopped()) return plc::InterruptedError();
  const Ended ended = Propagate(fresh, Plan::kRebuild);
  if (absl::Status status = StatusOf(ended, fresh); !status.ok()) return status;
  fresh.refinement.DetachTriangulation();
  const Stopwatch watch;
  meter.Begin(ApplyProgress::Stage::kDiff);
  built.mesh = fresh.diffs.Begin(fresh.refinement, fresh.features, steps);
  if (steps.stopped()) return plc::InterruptedError();
  built.diff_microseconds = watch.microseconds();
  if (absl::Status status = fresh.diffs.RegionStatus(); !status.ok()) return status;
  if (absl::Status status = fresh.diffs.NameStatus(fresh.refinement, fresh.features);
      !status.ok()) {
    return status;
  }
  fresh.features.Collect();
  return built;
}

template struct BatchRun<2>;
template struct BatchRun<3>;

}  // namespace dynmesh
