#include "core/dynamic_mesh/live_mesh.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "core/dynamic_mesh/batch_run.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/rebuild_choice.h"
#include "core/dynamic_mesh/stopwatch.h"
#include "core/dynamic_mesh/transaction.h"
#include "core/plc/messages.h"
#include "dynmesh/error.h"

namespace dynmesh {

absl::StatusOr<std::unique_ptr<DynamicMesh>> DynamicMesh::Create(const MeshOptions& options,
                                                                 const ApplyOptions& apply) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  return options.dimension == 2 ? LiveMesh<2>::Make(options, apply)
                                : LiveMesh<3>::Make(options, apply);
}

namespace {

Interrupt InterruptOf(const ApplyOptions& apply) {
  return apply.interrupted == nullptr ? Interrupt(Never) : Interrupt(apply.interrupted);
}

std::uint64_t MostOperations(const ApplyOptions& apply) {
  return apply.max_operations != 0 ? apply.max_operations
                                   : std::numeric_limits<std::uint64_t>::max();
}

}  // namespace

template <int D>
LiveMesh<D>::LiveMesh(const MeshOptions& options, const LiveMeshTuning& tuning)
    : LiveMesh(Unbegun(), options, tuning) {
  mesh_.Begin(Never);
}

template <int D>
absl::StatusOr<std::unique_ptr<DynamicMesh>> LiveMesh<D>::Make(const MeshOptions& options,
                                                               const ApplyOptions& apply) {
  if (absl::Status status = plc::CheckMaxEdge(options); !status.ok()) return status;
  std::unique_ptr<LiveMesh> mesh(new LiveMesh(Unbegun(), options, {}));
  const auto& refinement = mesh->mesh_.state->refinement;
  const sac::Counters& counters = refinement.engine().counters();
  const std::uint64_t most = MostOperations(apply);
  const Interrupt interrupt = InterruptOf(apply);
  const bool begun = mesh->mesh_.Begin([&] {
    return interrupt() || counters.executed > most ||
           IsOverLimits(refinement, options.limits.max_vertices);
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
absl::Status LiveMesh<D>::Validate(const EditBatch& batch) const {
  return mesh_.plc.Check(batch).status();
}

// The change that the batch makes, if it is valid.
template <int D>
absl::StatusOr<plc::Delta<D>> LiveMesh<D>::Check(const EditBatch& batch, ProgressMeter& meter,
                                                 Interrupt interrupt) const {
  meter.Begin(ApplyProgress::Stage::kValidate);
  std::size_t looked_at = 0;
  absl::StatusOr<plc::Delta<D>> delta = mesh_.plc.Check(batch, nullptr, [&](std::size_t waiting) {
    if (waiting != plc::kNotKnown) {
      meter.Step([&] { return ProgressMeter::Work{looked_at, looked_at + waiting}; });
      ++looked_at;
    }
    return interrupt();
  });
  if (!delta.ok()) return delta;
  meter.End(std::max(looked_at, delta->size()));
  if (delta->added_points.size() > mesh_.options.limits.max_vertices) {
    return VertexLimitError(mesh_.options.limits);
  }
  return delta;
}

template <int D>
absl::StatusOr<MeshDiff> LiveMesh<D>::Apply(const EditBatch& batch, const ApplyOptions& apply) {
  const Stopwatch watch;
  const Interrupt interrupt = InterruptOf(apply);
  double validated = 0;
  const auto commit = [&](MeshDiff& diff) {
    diff.from_revision = revision_;
    diff.to_revision = batch.empty() ? revision_ : revision_ + 1;
    diff.work.microseconds = watch.microseconds();
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
  absl::StatusOr<plc::Delta<D>> delta = Check(batch, meter, interrupt);
  if (!delta.ok()) return delta.status();
  validated = watch.microseconds();
  const Plan plan = PlanFor(*delta, mesh_.plc.size(), mesh_.state->refinement.vertex_count(),
                            mesh_.options.box, mesh_.tuning.rebuild);
  BatchRun<D> run{mesh_.options, mesh_.tuning, meter, interrupt, MostOperations(apply)};
  absl::StatusOr<MeshDiff> diff = Transaction<D>(mesh_, *delta, run, commit).Run(plan);
  if (!diff.ok()) return diff;
  revision_ = diff->to_revision;
  if (apply.revocable) {
    revocable_.push_back(*std::move(delta));
  } else {
    Settle();
  }
  GiveMemoryBack(interrupt);
  return diff;
}

template <int D>
void LiveMesh<D>::TakeBack(std::size_t revisions) {
  const auto last = std::span(revocable_).last(revisions);
  for (std::size_t i = revisions; i-- > 0;) {
    mesh_.plc.Commit(last[i].Inverse());  // first: Undo may rebuild the present features
    mesh_.Undo(last[i]);
    if (!mesh_.state->diffs.RegionStatus().ok()) mesh_.BuildPresent();  // perhaps of past sets
  }
  revision_ -= revisions;
  revocable_.resize(revocable_.size() - revisions);
}

// Removed items leave free room for later ones. Once most of the memory is free room, rebuilds the
// state: the same to the bit, without free room. It costs a run of the present operations. At least
// half as many were removed since there was no free room, so it is O(1) for each. Small meshes,
// built in a millisecond, are rebuilt sooner. If it is interrupted, a later batch rebuilds, once at
// most half as many operations are left.
template <int D>
void LiveMesh<D>::GiveMemoryBack(Interrupt interrupt) {
  constexpr std::size_t kSmall = 2048;
  constexpr double kPart = 0.25, kPartOfSmall = 0.67;
  const std::size_t operations = mesh_.state->refinement.engine().operation_count();
  const auto is_room = [&] {
    return mesh_.state->refinement.engine().IsMostlyRoom(operations < kSmall ? kPartOfSmall
                                                                             : kPart);
  };
  if (operations > give_back_at_ || !is_room()) return;
  mesh_.ReplaceState(interrupt);
  give_back_at_ = is_room() ? operations / 2 : std::numeric_limits<std::size_t>::max();
}

template class LiveMesh<2>;
template class LiveMesh<3>;

}  // namespace dynmesh
