#include "core/dynamic_mesh/live_mesh.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "core/base/time_slice.h"
#include "core/data/diff_meshes.h"
#include "core/dynamic_mesh/limits.h"
#include "core/plc/messages.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

using Clock = std::chrono::steady_clock;

double MicrosecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

}  // namespace

absl::StatusOr<std::unique_ptr<DynamicMesh>> DynamicMesh::Create(const MeshOptions& options,
                                                                 const ApplyOptions& apply) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  return options.dimension == 2 ? LiveMesh<2>::Make(options, apply)
                                : LiveMesh<3>::Make(options, apply);
}

namespace {

// Polled before each operation: is the batch cancelled?
class Stopper {
 public:
  explicit Stopper(const ApplyOptions& apply)
      : cancelled_(apply.cancelled), stopped_(apply.stopped) {
    if (apply.shares_core) slice_.emplace();
  }
  bool operator()() {
    if (slice_.has_value()) slice_->Step();
    return IsSet(cancelled_) || IsSet(stopped_);
  }

 private:
  static bool IsSet(const std::atomic<bool>* flag) {
    return flag != nullptr && flag->load(std::memory_order_relaxed);
  }

  const std::atomic<bool>*const cancelled_, *const stopped_;
  std::optional<TimeSlice> slice_;
};

constexpr auto kNever = [] { return false; };

std::uint64_t MostOperations(const ApplyOptions& apply) {
  return apply.max_operations != 0 ? apply.max_operations
                                   : std::numeric_limits<std::uint64_t>::max();
}

// A propagation holds new and obsolete vertices at once: so many are allowed during it.
std::uint64_t MostVerticesOnTheWay(const Limits& limits) {
  return limits.max_vertices + limits.max_vertices / 8 + 64;
}

}  // namespace

template <int D>
LiveMesh<D>::LiveMesh(const MeshOptions& options, const LiveMeshTuning& tuning)
    : LiveMesh(Unbegun(), options, tuning) {
  Begin(kNever);
}

template <int D>
LiveMesh<D>::LiveMesh(Unbegun, const MeshOptions& options, const LiveMeshTuning& tuning)
    : options_(options),
      tuning_(tuning),
      plc_(options),
      state_(std::make_unique<State>(options, tuning)) {}

template <int D>
template <class Interrupt>
bool LiveMesh<D>::Begin(Interrupt interrupt) {
  if (!state_->refinement.Propagate(interrupt)) return false;
  state_->refinement.DetachTriangulation();
  state_->diffs.Begin(state_->refinement, state_->features);
  return true;
}

template <int D>
absl::StatusOr<std::unique_ptr<DynamicMesh>> LiveMesh<D>::Make(const MeshOptions& options,
                                                               const ApplyOptions& apply) {
  if (absl::Status status = plc::CheckMaxEdge(options); !status.ok()) return status;
  std::unique_ptr<LiveMesh> mesh(new LiveMesh(Unbegun(), options, {}));
  const Refinement& refinement = mesh->state_->refinement;
  const sac::Counters& counters = refinement.engine().counters();
  const std::uint64_t most = MostOperations(apply);
  Stopper stopper(apply);
  const bool begun = mesh->Begin([&] {
    return stopper() || counters.executed > most || IsOverLimits(refinement, options.limits);
  });
  if (absl::Status status = LimitsStatus(refinement, options.limits); !status.ok()) return status;
  if (counters.executed > most) return WorkLimitError(most);
  if (!begun) {
    return MakeError(absl::StatusCode::kCancelled, "the mesh was given up while it was made",
                     {reason::kCancelled, {}, {}});
  }
  return mesh;
}

template <int D>
absl::StatusOr<MeshDiff> LiveMesh<D>::Apply(const EditBatch& batch, const ApplyOptions& apply) {
  if (apply.cancelled == nullptr && apply.stopped == nullptr && !apply.shares_core) {
    return ApplyWith(batch, apply, kNever);
  }
  Stopper stopper(apply);
  return ApplyWith(batch, apply, [&] { return stopper(); });
}

template <int D>
absl::StatusOr<MeshDiff> LiveMesh<D>::Apply(const EditBatch& batch,
                                            const std::function<bool()>& cancelled) {
  return ApplyWith(batch, {}, [&] { return cancelled(); });
}

template <int D>
absl::Status LiveMesh<D>::Validate(const EditBatch& batch) const {
  return plc_.Check(batch).status();
}

template <int D>
template <class Interrupt>
absl::StatusOr<MeshDiff> LiveMesh<D>::ApplyWith(const EditBatch& batch, const ApplyOptions& apply,
                                                Interrupt cancelled) {
  const auto start = Clock::now();
  double validated = 0;
  const auto commit = [&](MeshDiff& diff) {
    diff.from_revision = revision_;
    diff.to_revision = batch.empty() ? revision_ : revision_ + 1;
    diff.work.microseconds = MicrosecondsSince(start);
    diff.work.validate_microseconds = validated;
    return apply.commit == nullptr ? absl::OkStatus() : apply.commit(diff);
  };
  if (batch.empty()) {
    MeshDiff nothing;
    nothing.dimension = D;
    nothing.hash = hash();
    if (absl::Status status = commit(nothing); !status.ok()) return status;
    if (!apply.revocable) Settle();
    return nothing;
  }
  ProgressMeter meter(apply.progress);
  meter.Begin(ApplyProgress::Stage::kValidate);
  std::size_t looked_at = 0;
  absl::StatusOr<plc::Delta<D>> delta = plc_.Check(batch, nullptr, [&](std::size_t waiting) {
    if (waiting != plc::kNotKnown) {
      meter.Step([&] { return ProgressMeter::Work{looked_at, looked_at + waiting}; });
      ++looked_at;
    }
    return cancelled();
  });
  if (!delta.ok()) return delta.status();
  meter.End(std::max(looked_at, delta->size()));
  validated = MicrosecondsSince(start);
  if (delta->added_points.size() > options_.limits.max_vertices) {
    return VertexLimitError(options_.limits);
  }
  Task<Interrupt> job{*delta, meter, cancelled, commit, MostOperations(apply)};
  const Plan plan = PlanFor(*delta, plc_.size(), state_->refinement.vertex_count(), options_.box,
                            tuning_.rebuild);
  absl::StatusOr<MeshDiff> diff = plan == Plan::kRebuild ? Rebuild(job) : Propagate(job, plan);
  if (!diff.ok()) return diff;
  revision_ = diff->to_revision;
  if (apply.revocable) {
    revocable_.push_back(*std::move(delta));
  } else {
    Settle();
  }
  GiveMemoryBack(cancelled);
  return diff;
}

// Runs stale operations until there are none, or there is a reason to stop. A fresh state (from
// scratch) is never too dear, since there is no alternative.
template <int D>
template <class Job>
Ended LiveMesh<D>::Run(State& state, Job& job, Plan plan) {
  const bool fresh = plan == Plan::kRebuild;
  Refinement& refinement = state.refinement;
  const std::uint64_t nearest_before = refinement.nearest_run();
  std::uint64_t taken = 0;
  const auto work = [&] {
    // Each takes a third of the time of another operation: measured with uniform points and
    // segments.
    const std::uint64_t nearest = refinement.nearest_run() - nearest_before;
    const std::uint64_t done = taken - nearest / 3 * 2;
    const auto waiting = refinement.engine().waiting() -
                         refinement.engine().waiting_in(meshing::NearestEpoch()) / 3 * 2;
    return ProgressMeter::Work{done, done + waiting};
  };
  const sac::Counters& counters = refinement.engine().counters();
  const std::uint64_t most_vertices =
      fresh ? options_.limits.max_vertices : MostVerticesOnTheWay(options_.limits);
  PropagationCost cost(tuning_.rebuild, refinement.engine());
  const auto end = [&] {
    if (refinement.vertex_count() > most_vertices || refinement.hit_depth_limit() ||
        refinement.is_full()) {
      return Ended::kOverLimits;
    }
    if (job.executed + counters.executed > job.most_operations) return Ended::kOverWork;
    if (fresh) return Ended::kDone;
    const bool is_stale = plan == Plan::kLook && cost.IsMostlyStale();
    return is_stale || cost.IsTooDear() ? Ended::kTooDear : Ended::kDone;
  };
  Ended ended = Ended::kDone;
  const bool done = refinement.Propagate([&] {
    job.meter.Step(work);
    ++taken;
    ended = job.cancelled() ? Ended::kCancelled : end();
    return ended != Ended::kDone;
  });
  if (done) {
    ended = end();
    if (ended == Ended::kTooDear) ended = Ended::kDone;
  }
  // The engine's capacity is exceeded.
  if (!done && ended == Ended::kDone) ended = Ended::kOverLimits;
  if (ended == Ended::kDone) job.meter.End(work().done);
  return ended;
}

// The error of a run that was stopped; OK if it was not.
template <int D>
template <class Job>
absl::Status LiveMesh<D>::StatusOf(Ended ended, const Job& job, const State& state) const {
  switch (ended) {
    case Ended::kCancelled:
      return plc::InterruptedError();
    case Ended::kOverWork:
      return WorkLimitError(job.most_operations);
    default:
      return LimitsStatus(state.refinement, options_.limits);
  }
}

// The inverse edit restores the former trace, bit for bit. If that is too expensive, rebuilds from
// scratch.
template <int D>
void LiveMesh<D>::Undo(const plc::Delta<D>& delta) {
  State& state = *state_;
  state.refinement.engine().ResetCounters();
  state.features.Apply(delta.Inverse(), state.refinement);
  PropagationCost cost(tuning_.rebuild, state.refinement.engine());
  if (!state.refinement.Propagate([&] { return cost.IsTooDear(); })) return BuildPresent();
  state.refinement.ForgetDepthLimit();
  state.diffs.Update(state.refinement, state.features);
  state.features.Collect();
}

template <int D>
void LiveMesh<D>::TakeBack(std::size_t revisions) {
  const auto last = std::span(revocable_).last(revisions);
  for (std::size_t i = revisions; i-- > 0;) {
    plc_.Commit(last[i].Inverse());  // first: Undo may rebuild the present features
    Undo(last[i]);
    if (!state_->diffs.RegionStatus().ok()) BuildPresent();  // perhaps of past sets
  }
  revision_ -= revisions;
  revocable_.resize(revocable_.size() - revisions);
}

// Replaces the state by a new one of the present features. Keeps the old one if cancelled.
template <int D>
template <class Interrupt>
void LiveMesh<D>::ReplaceState(Interrupt cancelled) {
  const plc::Delta<D> all = plc_.FromNothing();
  const ProgressMeter::Listener no_listener;
  ProgressMeter silent(no_listener);
  const auto commit = [](MeshDiff&) { return absl::OkStatus(); };
  Task<Interrupt> job{all, silent, cancelled, commit, std::numeric_limits<std::uint64_t>::max()};
  absl::StatusOr<Built> built = Build(all, all.size(), job);
  if (built.ok()) state_ = std::move(built->state);
}

// Discards the state and builds that of the present features.
template <int D>
void LiveMesh<D>::BuildPresent() {
  state_.reset();  // frees its memory first
  ReplaceState(kNever);
}

// Applies the change to the refinement, many features in parts, so as to poll in between. Returns
// how many were applied: fewer than all if the job is cancelled.
template <int D>
template <class Job>
std::size_t LiveMesh<D>::HandOver(Job& job) {
  constexpr std::size_t kAtOnce = 256;
  const plc::Delta<D>& delta = job.delta;
  const std::size_t size = delta.size();
  // Surfaces are found from all removed and added facets together.
  const bool in_parts = delta.removed_facets.empty() && delta.added_facets.empty();
  if (size <= kAtOnce || !in_parts) {
    state_->features.Apply(delta, state_->refinement);
    return size;
  }
  for (std::size_t from = 0; from < size; from += kAtOnce) {
    if (job.cancelled()) return from;
    state_->features.Apply(delta.Part(from, std::min(size, from + kAtOnce)), state_->refinement);
  }
  return size;
}

template <int D>
template <class Job>
absl::StatusOr<MeshDiff> LiveMesh<D>::Propagate(Job& job, Plan plan) {
  State& state = *state_;
  const auto& engine = state.refinement.engine();
  state.refinement.engine().ResetCounters();
  state.refinement.ForgetDepthLimit();
  job.meter.Begin(ApplyProgress::Stage::kRefine);
  if (const std::size_t handed_over = HandOver(job); handed_over < job.delta.size()) {
    Undo(job.delta.Part(0, handed_over));
    return StatusOf(Ended::kCancelled, job, state);
  }
  const Ended ended = Run(state, job, plan);
  job.executed += engine.counters().executed;
  if (ended == Ended::kTooDear) {
    // The state is partly old, partly new. It is kept until the new state exists: undoing from here
    // costs at most as much as the propagation so far.
    absl::StatusOr<MeshDiff> diff = Rebuild(job);
    if (!diff.ok()) Undo(job.delta);
    return diff;
  }
  absl::Status status = StatusOf(ended, job, state);
  if (!status.ok()) {
    // A completed propagation has exactly the vertices that the features need. Other limits may be
    // exceeded only on the way, which depends on history: then a build from scratch decides.
    const bool is_told =
        ended == Ended::kCancelled || ended == Ended::kOverWork ||
        (ended == Ended::kDone && state.refinement.vertex_count() > options_.limits.max_vertices);
    Undo(job.delta);
    return is_told ? status : Rebuild(job);
  }
  return Finish(job);
}

// The diff of a completed propagation, if the batch may take effect.
template <int D>
template <class Job>
absl::StatusOr<MeshDiff> LiveMesh<D>::Finish(Job& job) {
  State& state = *state_;
  const auto propagated = Clock::now();
  job.meter.Begin(ApplyProgress::Stage::kDiff);
  MeshDiff diff = state.diffs.Update(state.refinement, state.features);
  diff.work.diff_microseconds = MicrosecondsSince(propagated);
  if (!state.diffs.RegionStatus().ok()) {
    // Labels are incomplete, so there is nothing to undo. Only a build from scratch determines
    // which polygon the error names.
    BuildPresent();
    return Rebuild(job);
  }
  const sac::Counters& counters = state.refinement.engine().counters();
  diff.work.executed = job.executed;
  diff.work.created = counters.created;
  diff.work.dropped = counters.dropped;
  job.meter.End();
  absl::Status status = state.diffs.NameStatus(state.refinement, state.features);
  // The diff has consumed the changes: an undo starts with none.
  state.features.Collect();
  if (status.ok()) status = job.commit(diff);
  if (!status.ok()) {
    Undo(job.delta);
    return status;
  }
  plc_.Commit(job.delta);
  return diff;
}

template <int D>
template <class Job>
absl::StatusOr<typename LiveMesh<D>::Built> LiveMesh<D>::Build(const plc::Delta<D>& all,
                                                               std::size_t features, Job& job) {
  Built built{std::make_unique<State>(options_, tuning_), {}, 0};
  State& fresh = *built.state;
  fresh.refinement.Reserve(features);
  job.meter.Begin(ApplyProgress::Stage::kRefine);
  Steps steps(job.cancelled);
  fresh.features.Apply(all, fresh.refinement, steps);
  const Ended ended = steps.stopped() ? Ended::kCancelled : Run(fresh, job, Plan::kRebuild);
  job.executed += fresh.refinement.engine().counters().executed;
  if (absl::Status status = StatusOf(ended, job, fresh); !status.ok()) return status;
  fresh.refinement.DetachTriangulation();
  const auto propagated = Clock::now();
  job.meter.Begin(ApplyProgress::Stage::kDiff);
  built.mesh = fresh.diffs.Begin(fresh.refinement, fresh.features, steps);
  if (steps.stopped()) return plc::InterruptedError();
  built.diff_microseconds = MicrosecondsSince(propagated);
  if (absl::Status status = fresh.diffs.RegionStatus(); !status.ok()) return status;
  if (absl::Status status = fresh.diffs.NameStatus(fresh.refinement, fresh.features);
      !status.ok()) {
    return status;
  }
  fresh.features.Collect();
  return built;
}

// Builds from scratch, beside the present state, which may be partly propagated.
template <int D>
template <class Job>
absl::StatusOr<MeshDiff> LiveMesh<D>::Rebuild(Job& job) {
  Steps steps(job.cancelled);
  Mesh before = state_->diffs.Snapshot(state_->refinement, state_->features, steps);
  if (steps.stopped()) return plc::InterruptedError();
  absl::StatusOr<Built> built = absl::UnknownError("");
  if (plc_.size() == 0) {
    built = Build(job.delta, job.delta.size(), job);
  } else {
    plc::Delta<D> all = plc_.FromNothing(steps);
    if (steps.stopped()) return plc::InterruptedError();
    all.Then(job.delta);
    built = Build(all, all.size(), job);
  }
  if (!built.ok()) return built.status();
  const auto made = Clock::now();
  MeshDiff diff = data::DiffMeshes(std::move(before), std::move(built->mesh), steps);
  if (steps.stopped()) return plc::InterruptedError();
  diff.work.diff_microseconds = built->diff_microseconds + MicrosecondsSince(made);
  diff.work.executed = job.executed;
  diff.work.created = built->state->refinement.engine().counters().created;
  diff.work.dropped = state_->refinement.engine().operation_count();
  job.meter.End();
  if (absl::Status status = job.commit(diff); !status.ok()) return status;
  state_ = std::move(built->state);
  plc_.Commit(job.delta);
  return diff;
}

// Removed items leave free room for later ones. Once most of the memory is free room, rebuilds the
// state: the same to the bit, without free room. It costs a run of the present operations. At least
// half as many were removed since there was no free room, so it is O(1) for each. Small meshes,
// built in a millisecond, are rebuilt sooner. If it is cancelled, a later batch rebuilds, once at
// most half as many operations are left.
template <int D>
template <class Interrupt>
void LiveMesh<D>::GiveMemoryBack(Interrupt cancelled) {
  constexpr std::size_t kSmall = 2048;
  constexpr double kPart = 0.25, kPartOfSmall = 0.67;
  const std::size_t operations = state_->refinement.engine().operation_count();
  const auto is_room = [&] {
    return state_->refinement.engine().IsMostlyRoom(operations < kSmall ? kPartOfSmall : kPart);
  };
  if (operations > give_back_at_ || !is_room()) return;
  ReplaceState(cancelled);
  give_back_at_ = is_room() ? operations / 2 : std::numeric_limits<std::size_t>::max();
}

template class LiveMesh<2>;
template class LiveMesh<3>;

}  // namespace dynmesh
