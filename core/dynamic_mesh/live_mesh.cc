#include "core/dynamic_mesh/live_mesh.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "core/dynamic_mesh/batch_run.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/meshed_features.h"
#include "core/dynamic_mesh/rebuild_choice.h"
#include "core/dynamic_mesh/transaction.h"
#include "core/plc/messages.h"

namespace dynmesh {

template <int D>
LiveMesh<D>::LiveMesh(Unbegun, const MeshOptions& options, const LiveMeshTuning& tuning)
    : mesh_(std::make_unique<MeshedFeatures<D>>(options, tuning)) {}

template <int D>
LiveMesh<D>::LiveMesh(const MeshOptions& options, const LiveMeshTuning& tuning)
    : LiveMesh(Unbegun(), options, tuning) {
  mesh_->Begin(Never);
}

template <int D>
LiveMesh<D>::~LiveMesh() = default;

template <int D>
absl::StatusOr<std::unique_ptr<DynamicMesh>> LiveMesh<D>::Make(const MeshOptions& options,
                                                               const ApplyOptions& apply) {
  if (absl::Status status = plc::CheckMaxEdge(options); !status.ok()) return status;
  std::unique_ptr<LiveMesh> mesh(new LiveMesh(Unbegun(), options, {}));
  const auto& refinement = mesh->mesh_->state->refinement;
  const sac::Counters& counters = refinement.engine().counters();
  const std::uint64_t most = MostOperations(apply.max_operations);
  const Interrupt interrupt = InterruptOf(apply.interrupted);
  const bool begun = mesh->mesh_->Begin([&] {
    return interrupt() || counters.executed > most ||
           IsOverLimits(refinement, options.limits.max_vertices);
  });
  if (absl::Status status = LimitsStatus(refinement, options); !status.ok()) return status;
  if (counters.executed > most) return WorkLimitError(most);
  if (!begun) return GivenUpError();
  return mesh;
}

template <int D>
const MeshOptions& LiveMesh<D>::options() const {
  return mesh_->options;
}
template <int D>
MeshHash LiveMesh<D>::hash() const {
  return mesh_->state->diffs.hash();
}
template <int D>
plc::Plc<D>& LiveMesh<D>::plc() {
  return mesh_->plc;
}
template <int D>
const plc::Plc<D>& LiveMesh<D>::plc() const {
  return mesh_->plc;
}

template <int D>
absl::StatusOr<MeshDiff> LiveMesh<D>::Run(const plc::Delta<D>& delta,
                                          const typename LiveFeatures<D>::Batch& batch,
                                          Commit commit) {
  const MeshState<D>& state = *mesh_->state;
  const Plan plan =
      PlanFor(delta, mesh_->plc.size(), state.refinement.vertex_count(), mesh_->options.box,
              mesh_->tuning.rebuild, [&](const plc::SizeFeature<D>& f) {
                return state.features.IsIdle(f, delta, state.refinement.complex().sizing);
              });
  BatchRun<D> run{mesh_->options, mesh_->tuning, batch.meter, batch.interrupt,
                  batch.most_operations};
  return Transaction<D>(*mesh_, delta, run, commit).Run(plan);
}

template <int D>
void LiveMesh<D>::Undo(const plc::Delta<D>& delta) {
  mesh_->Undo(delta);
  if (!mesh_->state->diffs.RegionStatus().ok()) mesh_->BuildPresent();  // perhaps of past sets
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
  const std::size_t operations = mesh_->state->refinement.engine().operation_count();
  const auto is_room = [&] {
    return mesh_->state->refinement.engine().IsMostlyRoom(operations < kSmall ? kPartOfSmall
                                                                              : kPart);
  };
  if (operations > give_back_at_ || !is_room()) return;
  mesh_->ReplaceState(interrupt);
  give_back_at_ = is_room() ? operations / 2 : std::numeric_limits<std::size_t>::max();
}

template class LiveMesh<2>;
template class LiveMesh<3>;

}  // namespace dynmesh
