#include "core/dynamic_mesh/live_mesh.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "core/base/time_slice.h"
#include "core/data/diff_meshes.h"
#include "core/dynamic_mesh/limits.h"
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

// Asked before each operation: is the work to be given up?
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

}  // namespace

template <int D>
LiveMesh<D>::LiveMesh(const MeshOptions& options, const LiveMeshTuning& tuning)
    : LiveMesh(Unbegun(), options, tuning) {
  Begin([] { return false; });
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
  std::unique_ptr<LiveMesh> mesh(new LiveMesh(Unbegun(), options, {}));
  const Refinement& refinement = mesh->state_->refinement;
  Stopper stopper(apply);
  const bool begun =
      mesh->Begin([&] { return stopper() || IsOverLimits(refinement, options.limits); });
  if (absl::Status status = LimitsStatus(refinement, options.limits); !status.ok()) return status;
  if (!begun) {
    return MakeError(absl::StatusCode::kCancelled, "the mesh was given up while it was made",
                     {reason::kCancelled, {}, {}});
  }
  return mesh;
}

template <int D>
absl::StatusOr<MeshDiff> LiveMesh<D>::Apply(const EditBatch& batch, const ApplyOptions& apply) {
  if (apply.cancelled == nullptr && apply.stopped == nullptr && !apply.shares_core) {
    return ApplyWith(batch, apply, [] { return false; });
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
    return nothing;
  }
  ProgressMeter meter(apply.progress);
  meter.Begin(ApplyProgress::Stage::kValidate);
  std::size_t looked_at = 0;
  const absl::StatusOr<plc::Delta<D>> delta = plc_.Check(batch, nullptr, [&](std::size_t waiting) {
    meter.Step([&] { return ProgressMeter::Work{looked_at, looked_at + waiting}; });
    ++looked_at;
    return cancelled();
  });
  if (!delta.ok()) return delta.status();
  meter.End(std::max(looked_at, delta->size()));
  validated = MicrosecondsSince(start);
  if (delta->added_points.size() > options_.limits.max_vertices) {
    return VertexLimitError(options_.limits);
  }
  const Plan plan = PlanFor(*delta, plc_.size(), state_->refinement.vertex_count(), options_.box,
                            tuning_.rebuild);
  absl::StatusOr<MeshDiff> diff =
      plan == Plan::kRebuild ? Rebuild(*delta, Snapshot(), meter, cancelled, commit)
                             : Propagate(*delta, plan == Plan::kLook, meter, cancelled, commit);
  if (diff.ok()) revision_ = diff->to_revision;
  return diff;
}

template <int D>
bool LiveMesh<D>::IsMostlyStale() const {
  const auto& engine = state_->refinement.engine();
  return static_cast<double>(engine.waiting()) >
         tuning_.rebuild.stale * static_cast<double>(engine.operation_count());
}

// Runs what is stale; a limit that is hit stops it.
template <int D>
template <class Interrupt>
absl::Status LiveMesh<D>::Run(State& state, ProgressMeter& meter, Interrupt cancelled) {
  Refinement& refinement = state.refinement;
  bool was_cancelled = false;
  const std::uint64_t nearest_before = refinement.nearest_run();
  std::uint64_t taken = 0;
  const auto work = [&] {
    // Beside the others' a third of the time: measured, of uniform points and segments.
    const std::uint64_t nearest = refinement.nearest_run() - nearest_before;
    const std::uint64_t done = taken - nearest / 3 * 2;
    const auto waiting = refinement.engine().waiting() -
                         refinement.engine().waiting_in(meshing::NearestEpoch()) / 3 * 2;
    return ProgressMeter::Work{done, done + waiting};
  };
  refinement.Propagate([&] {
    meter.Step(work);
    ++taken;
    was_cancelled = cancelled();
    return was_cancelled || IsOverLimits(refinement, options_.limits);
  });
  if (was_cancelled) {
    return MakeError(absl::StatusCode::kCancelled,
                     "the batch was cancelled; the mesh is as it was before",
                     {reason::kCancelled, {}, {}});
  }
  if (absl::Status status = LimitsStatus(refinement, options_.limits); !status.ok()) return status;
  meter.End(work().done);
  return absl::OkStatus();
}

// The inverse edit brings the former trace back, bit for bit.
template <int D>
void LiveMesh<D>::Undo(const plc::Delta<D>& delta) {
  State& state = *state_;
  state.features.Apply(delta.Inverse(), state.refinement);
  state.refinement.Propagate([] { return false; });
  state.refinement.ForgetDepthLimit();
  state.diffs.Update(state.refinement, state.features);
  state.features.Collect();
}

// `look`: it may turn out to be cheaper to build anew.
template <int D>
template <class Interrupt>
absl::StatusOr<MeshDiff> LiveMesh<D>::Propagate(const plc::Delta<D>& delta, bool look,
                                                ProgressMeter& meter, Interrupt cancelled,
                                                Commit commit) {
  State& state = *state_;
  state.refinement.engine().ResetCounters();
  state.refinement.ForgetDepthLimit();
  Mesh before = look ? Snapshot() : Mesh();
  meter.Begin(ApplyProgress::Stage::kRefine);
  state.features.Apply(delta, state.refinement);
  if (look && IsMostlyStale()) {
    absl::StatusOr<MeshDiff> diff = Rebuild(delta, std::move(before), meter, cancelled, commit);
    if (!diff.ok()) Undo(delta);
    return diff;
  }
  if (const absl::Status status = Run(state, meter, cancelled); !status.ok()) {
    Undo(delta);
    // On its way a propagation holds what is new and what is about to go: whether a limit is
    // passed only a run from scratch can say, lest the answer depend on history.
    if (absl::IsResourceExhausted(status))
      return Rebuild(delta, Snapshot(), meter, cancelled, commit);
    return status;
  }
  const auto propagated = Clock::now();
  meter.Begin(ApplyProgress::Stage::kDiff);
  MeshDiff diff = state.diffs.Update(state.refinement, state.features);
  diff.work.diff_microseconds = MicrosecondsSince(propagated);
  if (!state.diffs.RegionStatus().ok()) {
    // Labels are left half made, so that there is nothing to undo; and which polygon is to be
    // named, too, only a run from scratch can say.
    const ProgressMeter::Listener nobody;
    ProgressMeter silent(nobody);
    state_ = (*Build(plc_.FromNothing(), plc_.size(), silent, [] { return false; })).state;
    return Rebuild(delta, Snapshot(), meter, cancelled, commit);
  }
  const sac::Counters& counters = state.refinement.engine().counters();
  diff.work.executed = counters.executed;
  diff.work.created = counters.created;
  diff.work.dropped = counters.dropped;
  meter.End();
  absl::Status status = state.diffs.NameStatus(state.refinement, state.features);
  // The diff has taken what changed: the way back, too, begins with nothing that has.
  state.features.Collect();
  if (status.ok()) status = commit(diff);
  if (!status.ok()) {
    Undo(delta);
    return status;
  }
  plc_.Commit(delta);
  return diff;
}

template <int D>
template <class Interrupt>
absl::StatusOr<typename LiveMesh<D>::Built> LiveMesh<D>::Build(const plc::Delta<D>& all,
                                                               std::size_t features,
                                                               ProgressMeter& meter,
                                                               Interrupt cancelled) {
  Built built{std::make_unique<State>(options_, tuning_), {}, 0};
  State& fresh = *built.state;
  fresh.refinement.Reserve(features);
  meter.Begin(ApplyProgress::Stage::kRefine);
  fresh.features.Apply(all, fresh.refinement);
  if (absl::Status status = Run(fresh, meter, cancelled); !status.ok()) return status;
  fresh.refinement.DetachTriangulation();
  const auto propagated = Clock::now();
  meter.Begin(ApplyProgress::Stage::kDiff);
  built.mesh = fresh.diffs.Begin(fresh.refinement, fresh.features);
  built.diff_microseconds = MicrosecondsSince(propagated);
  if (absl::Status status = fresh.diffs.RegionStatus(); !status.ok()) return status;
  if (absl::Status status = fresh.diffs.NameStatus(fresh.refinement, fresh.features);
      !status.ok()) {
    return status;
  }
  fresh.features.Collect();
  return built;
}

template <int D>
template <class Interrupt>
absl::StatusOr<MeshDiff> LiveMesh<D>::Rebuild(const plc::Delta<D>& delta, Mesh before,
                                              ProgressMeter& meter, Interrupt cancelled,
                                              Commit commit) {
  const bool is_first = plc_.size() == 0;
  plc_.Commit(delta);
  absl::StatusOr<Built> built =
      Build(is_first ? delta : plc_.FromNothing(), plc_.size(), meter, cancelled);
  const auto refuse = [&](absl::Status status) {
    plc_.Commit(delta.Inverse());
    return status;
  };
  if (!built.ok()) return refuse(built.status());
  const auto made = Clock::now();
  MeshDiff diff = data::DiffMeshes(std::move(before), std::move(built->mesh));
  diff.work.diff_microseconds = built->diff_microseconds + MicrosecondsSince(made);
  const sac::Counters& counters = built->state->refinement.engine().counters();
  diff.work.executed = counters.executed;
  diff.work.created = counters.created;
  diff.work.dropped = state_->refinement.engine().operation_count();
  meter.End();
  if (absl::Status status = commit(diff); !status.ok()) return refuse(std::move(status));
  state_ = std::move(built->state);
  return diff;
}

template <int D>
Mesh LiveMesh<D>::Snapshot() const {
  Mesh mesh = state_->diffs.Snapshot(state_->refinement, state_->features);
  mesh.revision = revision_;
  return mesh;
}

template <int D>
SimplexColumn LiveMesh<D>::Locate(std::span<const double> points) const {
  SimplexColumn result;
  result.reserve(points.size() / D * (D + 1));
  const auto& triangulation = state_->diffs.triangulation();
  const auto& rules = state_->refinement.rules();
  meshing::VertexIndex near = 0;
  for (; points.size() >= D; points = points.subspan(D)) {
    geometry::Point<D> p;
    bool inside = true;
    for (int k = 0; k < D; ++k) {
      p[k] = points[static_cast<std::size_t>(k)];
      inside = inside && rules.lo()[k] <= p[k] && p[k] <= rules.hi()[k];
    }
    std::array<VertexId, D + 1> ids = {};
    if (inside) {
      const auto t = triangulation.Locate(p, near);
      if (!triangulation.IsInfinite(t)) {
        near = triangulation.vertices(t)[0];
        ids = state_->diffs.CanonicalIds(t);
      }
    }
    result.insert(result.end(), ids.begin(), ids.end());
  }
  return result;
}

template <int D>
MeshStats LiveMesh<D>::Stats() const {
  const State& s = *state_;
  MeshStats stats;
  stats.revision = revision_;
  stats.features = plc_.size();
  stats.vertices = s.refinement.vertex_count();
  stats.simplices = s.diffs.triangulation().simplex_count();
  stats.subsegments = s.diffs.subsegment_count();
  stats.subfacets = s.diffs.subfacet_count();
  stats.operations = s.refinement.engine().operation_count();
  stats.trace_bytes = s.refinement.trace_bytes();
  stats.mesh_bytes = s.refinement.bytes() + s.diffs.bytes() + s.features.bytes();
  return stats;
}

template <int D>
AuditReport LiveMesh<D>::Audit() const {
  AuditReport report;
  const std::uint64_t trace = state_->refinement.Audit(&report.problems);
  report.trace = {trace, state_->refinement.engine().operation_count()};
  std::string why;
  if (!state_->diffs.triangulation().Check(&why)) report.problems.push_back("mesh: " + why);
  if (!state_->diffs.CheckLabels()) {
    report.problems.push_back("regions of neighbours do not agree with the edges between them");
  }
  const Mesh mesh = Snapshot();
  if (!(ComputeHash(mesh) == mesh.hash)) {
    report.problems.push_back("the hash kept is not that of the mesh");
  }
  if (mesh.vertices.size() != state_->diffs.triangulation().vertex_count()) {
    report.problems.push_back("the triangulation's vertices are not those present");
  }
  return report;
}

template class LiveMesh<2>;
template class LiveMesh<3>;

}  // namespace dynmesh
