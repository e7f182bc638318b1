#include "core/dynamic_mesh/planar_mesh.h"

#include <chrono>
#include <utility>

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

absl::StatusOr<std::unique_ptr<DynamicMesh>> DynamicMesh::Create(const MeshOptions& options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  return std::unique_ptr<DynamicMesh>(std::make_unique<PlanarMesh>(options));
}

PlanarMesh::PlanarMesh(const MeshOptions& options, const PlanarMeshTuning& tuning)
    : options_(options),
      tuning_(tuning),
      plc_(options),
      state_(std::make_unique<State>(options, tuning)) {
  // The bare box is within any limit that ValidateOptions accepts.
  state_->refinement.Propagate([] { return false; });
  state_->refinement.DetachTriangulation();
  state_->diffs.Begin(state_->refinement, state_->features);
}

absl::StatusOr<MeshDiff> PlanarMesh::Apply(const EditBatch& batch, const ApplyOptions& apply) {
  if (apply.cancelled == nullptr) {
    return ApplyWith(batch, [] { return false; });
  }
  return ApplyWith(batch, [&] { return apply.cancelled->load(std::memory_order_relaxed); });
}

absl::StatusOr<MeshDiff> PlanarMesh::Apply(const EditBatch& batch,
                                           const std::function<bool()>& cancelled) {
  return ApplyWith(batch, [&] { return cancelled(); });
}

absl::Status PlanarMesh::Validate(const EditBatch& batch) const {
  return plc_.Check(batch).status();
}

template <class Interrupt>
absl::StatusOr<MeshDiff> PlanarMesh::ApplyWith(const EditBatch& batch, Interrupt cancelled) {
  const auto start = Clock::now();
  if (batch.empty()) {
    MeshDiff nothing;
    nothing.from_revision = nothing.to_revision = revision_;
    nothing.hash = hash();
    return nothing;
  }
  const absl::StatusOr<plc::Delta<2>> delta = plc_.Check(batch, nullptr, cancelled);
  if (!delta.ok()) return delta.status();
  const Plan plan = PlanFor(*delta, plc_.size(), state_->refinement.vertex_count(), options_.box,
                            tuning_.rebuild);
  absl::StatusOr<MeshDiff> diff = plan == Plan::kRebuild
                                      ? Rebuild(*delta, Snapshot(), cancelled)
                                      : Propagate(*delta, plan == Plan::kLook, cancelled);
  if (!diff.ok()) return diff;
  diff->from_revision = revision_;
  diff->to_revision = ++revision_;
  diff->work.microseconds = MicrosecondsSince(start);
  return diff;
}

bool PlanarMesh::IsMostlyStale() const {
  const auto& engine = state_->refinement.engine();
  return static_cast<double>(engine.waiting()) >
         tuning_.rebuild.stale * static_cast<double>(engine.operation_count());
}

// Runs what is stale; a limit that is hit stops it.
template <class Interrupt>
absl::Status PlanarMesh::Run(State& state, Interrupt cancelled) {
  Refinement& refinement = state.refinement;
  bool was_cancelled = false;
  refinement.Propagate([&] {
    was_cancelled = cancelled();
    return was_cancelled || IsOverLimits(refinement, options_.limits);
  });
  if (was_cancelled) {
    return MakeError(absl::StatusCode::kCancelled,
                     "the batch was cancelled; the mesh is as it was before",
                     {reason::kCancelled, {}, {}});
  }
  return LimitsStatus(refinement, options_.limits);
}

// The inverse edit brings the former trace back, bit for bit.
void PlanarMesh::Undo(const plc::Delta<2>& delta) {
  State& state = *state_;
  state.features.Apply(delta.Inverse(), state.refinement);
  state.refinement.Propagate([] { return false; });
  state.refinement.ForgetDepthLimit();
  state.diffs.Update(state.refinement, state.features);
  state.features.Collect();
}

// `look`: it may turn out to be cheaper to build anew.
template <class Interrupt>
absl::StatusOr<MeshDiff> PlanarMesh::Propagate(const plc::Delta<2>& delta, bool look,
                                               Interrupt cancelled) {
  State& state = *state_;
  state.refinement.engine().ResetCounters();
  state.refinement.ForgetDepthLimit();
  Mesh before = look ? Snapshot() : Mesh();
  state.features.Apply(delta, state.refinement);
  if (look && IsMostlyStale()) {
    absl::StatusOr<MeshDiff> diff = Rebuild(delta, std::move(before), cancelled);
    if (!diff.ok()) Undo(delta);
    return diff;
  }
  if (const absl::Status status = Run(state, cancelled); !status.ok()) {
    Undo(delta);
    // On its way a propagation holds what is new and what is about to go: whether a limit is
    // passed only a run from scratch can say, lest the answer depend on history.
    if (absl::IsResourceExhausted(status)) return Rebuild(delta, Snapshot(), cancelled);
    return status;
  }
  MeshDiff diff = state.diffs.Update(state.refinement, state.features);
  if (!state.diffs.RegionStatus().ok()) {
    // Labels are left half made, so that there is nothing to undo; and which polygon is to be
    // named, too, only a run from scratch can say.
    state_ = (*Build(plc_.FromNothing(), plc_.size(), [] { return false; })).state;
    return Rebuild(delta, Snapshot(), cancelled);
  }
  plc_.Commit(delta);
  state.features.Collect();
  const sac::Counters& counters = state.refinement.engine().counters();
  diff.work.executed = counters.executed;
  diff.work.created = counters.created;
  diff.work.dropped = counters.dropped;
  return diff;
}

template <class Interrupt>
absl::StatusOr<PlanarMesh::Built> PlanarMesh::Build(const plc::Delta<2>& all, std::size_t features,
                                                    Interrupt cancelled) {
  Built built{std::make_unique<State>(options_, tuning_), {}};
  State& fresh = *built.state;
  fresh.refinement.Reserve(features);
  fresh.features.Apply(all, fresh.refinement);
  if (absl::Status status = Run(fresh, cancelled); !status.ok()) return status;
  fresh.refinement.DetachTriangulation();
  built.mesh = fresh.diffs.Begin(fresh.refinement, fresh.features);
  if (absl::Status status = fresh.diffs.RegionStatus(); !status.ok()) return status;
  fresh.features.Collect();
  return built;
}

template <class Interrupt>
absl::StatusOr<MeshDiff> PlanarMesh::Rebuild(const plc::Delta<2>& delta, Mesh before,
                                             Interrupt cancelled) {
  const bool is_first = plc_.size() == 0;
  plc_.Commit(delta);
  absl::StatusOr<Built> built =
      Build(is_first ? delta : plc_.FromNothing(), plc_.size(), cancelled);
  if (!built.ok()) {
    plc_.Commit(delta.Inverse());
    return built.status();
  }
  MeshDiff diff = data::DiffMeshes(std::move(before), std::move(built->mesh));
  const sac::Counters& counters = built->state->refinement.engine().counters();
  diff.work.executed = counters.executed;
  diff.work.created = counters.created;
  diff.work.dropped = state_->refinement.engine().operation_count();
  state_ = std::move(built->state);
  return diff;
}

Mesh PlanarMesh::Snapshot() const {
  Mesh mesh = state_->diffs.Snapshot(state_->refinement, state_->features);
  mesh.revision = revision_;
  return mesh;
}

SimplexColumn PlanarMesh::Locate(std::span<const double> points) const {
  SimplexColumn result;
  result.reserve(points.size() / 2 * 3);
  const mesh::DelaunayTriangulation& triangulation = state_->diffs.triangulation();
  meshing::VertexIndex near = 0;
  for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
    const geometry::Point2 p = {{points[i], points[i + 1]}};
    std::array<VertexId, 3> ids = {0, 0, 0};
    const meshing::PlanarRules& rules = state_->refinement.rules();
    if (rules.lo()[0] <= p[0] && p[0] <= rules.hi()[0] && rules.lo()[1] <= p[1] &&
        p[1] <= rules.hi()[1]) {
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

MeshStats PlanarMesh::Stats() const {
  const State& s = *state_;
  MeshStats stats;
  stats.revision = revision_;
  stats.features = plc_.size();
  stats.vertices = s.refinement.vertex_count();
  stats.simplices = s.diffs.triangulation().triangle_count();
  stats.subsegments = s.diffs.subsegment_count();
  stats.operations = s.refinement.engine().operation_count();
  stats.trace_bytes = s.refinement.trace_bytes();
  stats.mesh_bytes = s.refinement.bytes() + s.diffs.bytes() + s.features.bytes();
  return stats;
}

AuditReport PlanarMesh::Audit() const {
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

}  // namespace dynmesh
