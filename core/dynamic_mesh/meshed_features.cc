#include "core/dynamic_mesh/meshed_features.h"

#include <limits>
#include <utility>

#include "core/dynamic_mesh/batch_run.h"

namespace dynmesh {

template <int D>
bool MeshedFeatures<D>::Begin(Interrupt interrupt) {
  if (!state->refinement.Propagate(interrupt)) return false;
  state->refinement.DetachTriangulation();
  state->diffs.Begin(state->refinement, state->features);
  return true;
}

template <int D>
void MeshedFeatures<D>::Undo(const plc::Delta<D>& delta) {
  state->refinement.engine().ResetCounters();
  state->features.Apply(delta.Inverse(), state->refinement);
  PropagationCost cost(tuning.rebuild, D, state->refinement.engine());
  if (!state->refinement.Propagate([&] { return cost.IsTooDear(); })) return BuildPresent();
  state->refinement.ForgetDepthLimit();
  state->diffs.Update(state->refinement, state->features);
  state->features.Collect();
}

template <int D>
void MeshedFeatures<D>::BuildPresent() {
  state.reset();  // frees its memory first
  ReplaceState(Never);
}

template <int D>
void MeshedFeatures<D>::ReplaceState(Interrupt interrupt) {
  const plc::Delta<D> all = plc.FromNothing();
  const ProgressMeter::Listener no_listener;
  ProgressMeter silent(no_listener);
  BatchRun<D> run{options, tuning, silent, interrupt, std::numeric_limits<std::uint64_t>::max()};
  absl::StatusOr<Built<D>> built = run.Build(all, all.size());
  if (built.ok()) state = std::move(built->state);
}

template struct MeshedFeatures<2>;
template struct MeshedFeatures<3>;

}  // namespace dynmesh
