#include "core/dynamic_mesh/build_mesh.h"

#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/live_mesh.h"

namespace dynmesh {

// Reads neighbourhoods from one growing triangulation.
template <int D>
absl::StatusOr<Mesh> BuildDelaunay(std::span<const Feature> features, const MeshOptions& options,
                                   const BuildOptions& build) {
  const Interrupt interrupt = InterruptOf(build.interrupted);
  const std::uint64_t most = MostOperations(build.max_operations);
  ProgressMeter meter(build.progress);
  plc::Plc<D> plc(options);
  const absl::StatusOr<plc::Delta<D>> delta =
      CheckBatch(plc, plc::Edits::Adding(features), options, meter, interrupt);
  if (absl::IsCancelled(delta.status())) return GivenUpError();
  if (!delta.ok()) return delta.status();

  meter.Begin(ApplyProgress::Stage::kRefine);
  Steps steps(interrupt);
  DiffBuilder<D> diffs;
  FeatureTable<D> table;
  meshing::Refinement<D, sac::UntracedEngine> refinement(options, &diffs.triangulation());
  refinement.Reserve(delta->added_points.size());
  table.Apply(*delta, refinement, steps);
  if (steps.stopped()) return GivenUpError();
  const auto& engine = refinement.engine();
  const auto work = [&] {
    const std::uint64_t done = engine.executed();
    return ProgressMeter::Work{done, done + engine.waiting()};
  };
  bool is_interrupted = false;
  refinement.Propagate([&] {
    meter.Step(work);
    is_interrupted = interrupt();
    return is_interrupted || engine.executed() > most ||
           IsOverLimits(refinement, options.limits.max_vertices);
  });
  if (is_interrupted) return GivenUpError();
  if (absl::Status status = LimitsStatus(refinement, options); !status.ok()) return status;
  if (engine.executed() > most) return WorkLimitError(most);
  meter.End(work().done);

  meter.Begin(ApplyProgress::Stage::kDiff);
  Mesh mesh = diffs.Begin(refinement, table, steps);
  if (steps.stopped()) return GivenUpError();
  if (absl::Status status = diffs.RegionStatus(); !status.ok()) return status;
  if (absl::Status status = diffs.NameStatus(refinement, table); !status.ok()) return status;
  mesh.revision = features.empty() ? 0 : 1;
  meter.End();
  return mesh;
}

template absl::StatusOr<Mesh> BuildDelaunay<2>(std::span<const Feature>, const MeshOptions&,
                                               const BuildOptions&);
template absl::StatusOr<Mesh> BuildDelaunay<3>(std::span<const Feature>, const MeshOptions&,
                                               const BuildOptions&);

}  // namespace dynmesh
