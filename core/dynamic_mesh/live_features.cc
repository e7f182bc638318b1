#include "core/dynamic_mesh/live_features.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

#include "core/base/steps.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/stopwatch.h"
#include "core/plc/messages.h"

namespace dynmesh {

Interrupt InterruptOf(const std::function<bool()>& interrupted) {
  return interrupted == nullptr ? Interrupt(Never) : Interrupt(interrupted);
}

template <int D>
absl::Status LiveFeatures<D>::Validate(const EditBatch& batch) const {
  return plc().Check(batch).status();
}

template <int D>
std::vector<Feature> LiveFeatures<D>::Features() const {
  std::vector<Feature> features = plc().Features();
  labels_.AddTo(features);
  return features;
}

template <int D>
absl::StatusOr<plc::Delta<D>> CheckBatch(const plc::Plc<D>& plc, const plc::Edits& batch,
                                         const MeshOptions& options, ProgressMeter& meter,
                                         Interrupt interrupt) {
  meter.Begin(ApplyProgress::Stage::kValidate);
  std::size_t looked_at = 0;
  absl::StatusOr<plc::Delta<D>> delta = plc.Check(batch, nullptr, [&](std::size_t waiting) {
    if (waiting != plc::kNotKnown) {
      meter.Step([&] { return ProgressMeter::Work{looked_at, looked_at + waiting}; });
      ++looked_at;
    }
    return interrupt();
  });
  if (!delta.ok()) return delta;
  meter.End(std::max(looked_at, delta->size()));
  if (delta->added_points.size() > options.limits.max_vertices) return VertexLimitError(options);
  return delta;
}

template <int D>
absl::StatusOr<plc::Delta<D>> CheckFeatures(const plc::Plc<D>& plc,
                                            std::span<const Feature> features,
                                            const MeshOptions& options, const ValidFeatures* valid,
                                            ProgressMeter& meter, Interrupt interrupt) {
  const plc::Edits batch = plc::Edits::Adding(features);
  if (valid == nullptr || !valid->Proves(features, options)) {
    return CheckBatch(plc, batch, options, meter, interrupt);
  }
  meter.Begin(ApplyProgress::Stage::kValidate);
  absl::StatusOr<plc::Delta<D>> delta =
      plc.ChangeOfValid(batch, [&](std::size_t) { return interrupt(); });
  if (!delta.ok()) return delta;
  meter.End(delta->size());
  if (delta->added_points.size() > options.limits.max_vertices) return VertexLimitError(options);
  return delta;
}

template <int D>
absl::StatusOr<MeshDiff> LiveFeatures<D>::Apply(const EditBatch& batch, const ApplyOptions& apply) {
  const Stopwatch watch;
  const Interrupt interrupt = InterruptOf(apply.interrupted);
  double validated = 0;
  plc::LabelChanges labels;
  const auto commit = [&](MeshDiff& diff) {
    diff.from_revision = revision_;
    diff.to_revision = batch.empty() ? revision_ : revision_ + 1;
    diff.work.microseconds = watch.microseconds();
    diff.work.validate_microseconds = validated;
    diff.labels = plc::RowsOf(labels);
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
  absl::StatusOr<plc::Delta<D>> delta =
      CheckBatch(plc(), plc::Edits(batch), options(), meter, interrupt);
  if (!delta.ok()) return delta.status();
  Steps steps(interrupt);
  labels = labels_.ChangesBy(plc::Edits(batch), steps);
  if (steps.stopped()) return plc::InterruptedError();
  validated = watch.microseconds();
  absl::StatusOr<MeshDiff> diff =
      Run(*delta, {meter, interrupt, MostOperations(apply.max_operations)}, commit);
  if (!diff.ok()) return diff;
  revision_ = diff->to_revision;
  labels_.Apply(labels);
  if (apply.revocable) {
    revocable_.push_back({*std::move(delta), std::move(labels)});
  } else {
    Settle();
  }
  GiveMemoryBack(interrupt);
  return diff;
}

template <int D>
void LiveFeatures<D>::TakeBack(std::size_t revisions) {
  for (std::size_t i = 0; i < revisions; ++i) {
    const Revocable& last = revocable_.back();
    plc().Apply(last.delta.Inverse());  // first: Undo may rebuild the present features
    Undo(last.delta);
    labels_.Undo(last.labels);
    revocable_.pop_back();
  }
  revision_ -= revisions;
}

template <int D>
void LiveFeatures<D>::SettleAllBut(std::size_t revisions) {
  assert(revisions <= revocable_.size());
  revocable_.erase(revocable_.begin(), revocable_.end() - static_cast<std::ptrdiff_t>(revisions));
}

template absl::StatusOr<plc::Delta<2>> CheckBatch(const plc::Plc<2>&, const plc::Edits&,
                                                  const MeshOptions&, ProgressMeter&, Interrupt);
template absl::StatusOr<plc::Delta<3>> CheckBatch(const plc::Plc<3>&, const plc::Edits&,
                                                  const MeshOptions&, ProgressMeter&, Interrupt);
template absl::StatusOr<plc::Delta<2>> CheckFeatures(const plc::Plc<2>&, std::span<const Feature>,
                                                     const MeshOptions&, const ValidFeatures*,
                                                     ProgressMeter&, Interrupt);
template absl::StatusOr<plc::Delta<3>> CheckFeatures(const plc::Plc<3>&, std::span<const Feature>,
                                                     const MeshOptions&, const ValidFeatures*,
                                                     ProgressMeter&, Interrupt);
template class LiveFeatures<2>;
template class LiveFeatures<3>;

}  // namespace dynmesh
