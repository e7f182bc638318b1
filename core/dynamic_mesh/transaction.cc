#include "core/dynamic_mesh/transaction.h"

#include <algorithm>
#include <utility>

#include "core/base/steps.h"
#include "core/dynamic_mesh/finest_place.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/stopwatch.h"
#include "core/mesh_data/diff_meshes.h"
#include "core/plc/messages.h"

namespace dynmesh {

template <int D>
absl::StatusOr<MeshDiff> Transaction<D>::Run(Plan plan) {
  Outcome outcome = plan == Plan::kRebuild ? Outcome::kUndecided : RunInPlace(plan);
  if (outcome == Outcome::kUndecided) outcome = RunFromScratch();
  if (outcome == Outcome::kReady) {
    run_.meter.End();
    status_ = commit_(diff_);
  }
  if (!status_.ok()) {
    RollBack();
    return outcome == Outcome::kRefused
               ? NameFinestPlace(std::move(status_), delta_, mesh_.plc, run_.options)
               : status_;
  }
  Accept();
  return std::move(diff_);
}

template <int D>
typename Transaction<D>::Outcome Transaction<D>::Refuse(absl::Status status) {
  status_ = std::move(status);
  return Outcome::kRefused;
}

// --- In place -----------------------------------------------------------------------------

template <int D>
typename Transaction<D>::Outcome Transaction<D>::RunInPlace(Plan plan) {
  MeshState<D>& state = *mesh_.state;
  state.refinement.engine().ResetCounters();
  visited_cells_ = state.refinement.visited_cells();
  visited_nodes_ = state.refinement.visited_nodes();
  state.refinement.ForgetDepthLimit();
  run_.meter.Begin(ApplyProgress::Stage::kRefine);
  applied_ = BeginInPlace();
  if (applied_ < delta_.size()) return Refuse(plc::InterruptedError());
  const Ended ended = run_.Propagate(state, plan);
  if (ended == Ended::kTooDear) return Outcome::kUndecided;
  if (absl::Status status = run_.StatusOf(ended, state); !status.ok()) {
    // A completed propagation has exactly the vertices that the features need. Other limits may be
    // exceeded only on the way.
    const bool is_certain = ended != Ended::kOverLimits;
    return is_certain ? Refuse(std::move(status)) : Outcome::kUndecided;
  }
  return DiffInPlace();
}

// Applies the change to the refinement, many features in parts, so as to poll in between. Returns
// how many were applied: fewer than all if it was interrupted.
template <int D>
std::size_t Transaction<D>::BeginInPlace() {
  constexpr std::size_t kAtOnce = 256;
  MeshState<D>& state = *mesh_.state;
  const std::size_t size = delta_.size();
  // Surfaces are found from all removed and added facets together.
  const bool in_parts = delta_.removed_facets.empty() && delta_.added_facets.empty();
  if (size <= kAtOnce || !in_parts) {
    state.features.Apply(delta_, state.refinement);
    return size;
  }
  for (std::size_t from = 0; from < size; from += kAtOnce) {
    if (run_.interrupt()) return from;
    state.features.Apply(delta_.Part(from, std::min(size, from + kAtOnce)), state.refinement);
  }
  return size;
}

template <int D>
typename Transaction<D>::Outcome Transaction<D>::DiffInPlace() {
  MeshState<D>& state = *mesh_.state;
  const Stopwatch watch;
  run_.meter.Begin(ApplyProgress::Stage::kDiff);
  diff_ = state.diffs.Update(state.refinement, state.features);
  diff_.work.diff_microseconds = watch.microseconds();
  if (!state.diffs.RegionStatus().ok()) {
    // Labels are incomplete, so there is nothing to undo. Only a build from scratch determines
    // which polygon the error names.
    mesh_.BuildPresent();
    applied_ = 0;
    return Outcome::kUndecided;
  }
  CountWork(state);
  diff_.work.dropped = state.refinement.engine().counters().dropped;
  diff_.work.visited_cells -= visited_cells_;
  diff_.work.visited_nodes -= visited_nodes_;
  absl::Status status = state.diffs.NameStatus(state.refinement, state.features);
  // The diff has consumed the changes: an undo starts with none.
  state.features.Collect();
  return status.ok() ? Outcome::kReady : Refuse(std::move(status));
}

template <int D>
void Transaction<D>::CountWork(const MeshState<D>& state) {
  const sac::Counters& counters = state.refinement.engine().counters();
  diff_.work.executed = run_.executed;
  diff_.work.created = counters.created;
  diff_.work.notified = counters.notified;
  diff_.work.visited_cells = state.refinement.visited_cells();
  diff_.work.visited_nodes = state.refinement.visited_nodes();
}

// --- From scratch ---------------------------------------------------------------------------

template <int D>
typename Transaction<D>::Outcome Transaction<D>::RunFromScratch() {
  const MeshState<D>& present = *mesh_.state;
  Steps steps(run_.interrupt);
  Mesh before = present.diffs.Snapshot(present.refinement, present.features, steps);
  if (steps.stopped()) return Refuse(plc::InterruptedError());
  absl::StatusOr<Built<D>> built = absl::UnknownError("");
  if (mesh_.plc.size() == 0) {
    built = run_.Build(delta_, delta_.size());
  } else {
    plc::Delta<D> all = mesh_.plc.FromNothing(steps);
    if (steps.stopped()) return Refuse(plc::InterruptedError());
    all.Then(delta_);
    built = run_.Build(all, all.size());
  }
  if (!built.ok()) return Refuse(built.status());
  const Stopwatch watch;
  diff_ = mesh_data::DiffMeshes(std::move(before), std::move(built->mesh), steps);
  if (steps.stopped()) return Refuse(plc::InterruptedError());
  diff_.work.diff_microseconds = built->diff_microseconds + watch.microseconds();
  CountWork(*built->state);
  diff_.work.dropped = present.refinement.engine().operation_count();
  built_ = std::move(built->state);
  return Outcome::kReady;
}

// --- The end ------------------------------------------------------------------------------

template <int D>
void Transaction<D>::Accept() {
  if (built_ != nullptr) mesh_.state = std::move(built_);
  mesh_.plc.Apply(delta_);
}

template <int D>
void Transaction<D>::RollBack() {
  built_.reset();
  if (applied_ == 0) return;
  mesh_.Undo(applied_ == delta_.size() ? delta_ : delta_.Part(0, applied_));
}

template class Transaction<2>;
template class Transaction<3>;

}  // namespace dynmesh
