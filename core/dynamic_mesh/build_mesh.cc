// BuildMesh: no trace; reads neighbourhoods from one growing triangulation.
#include <memory>

#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/live_mesh.h"
#include "core/plc/messages.h"

namespace dynmesh {

namespace {

template <int D>
absl::StatusOr<Mesh> Build(std::span<const Feature> features, const MeshOptions& options) {
  plc::Plc<D> plc(options);
  const absl::StatusOr<plc::Delta<D>> delta = plc.Check(plc::Edits::Adding(features));
  if (!delta.ok()) return delta.status();
  if (delta->added_points.size() > options.limits.max_vertices) {
    return VertexLimitError(options.limits);
  }

  DiffBuilder<D> diffs;
  FeatureTable<D> table;
  meshing::Refinement<D, sac::UntracedEngine> refinement(options, &diffs.triangulation());
  refinement.Reserve(delta->added_points.size());
  table.Apply(*delta, refinement);
  refinement.Propagate([&] { return IsOverLimits(refinement, options.limits.max_vertices); });
  if (absl::Status status = LimitsStatus(refinement, options.limits); !status.ok()) return status;
  Mesh mesh = diffs.Begin(refinement, table);
  if (absl::Status status = diffs.RegionStatus(); !status.ok()) return status;
  if (absl::Status status = diffs.NameStatus(refinement, table); !status.ok()) return status;
  mesh.revision = features.empty() ? 0 : 1;
  return mesh;
}

}  // namespace

absl::StatusOr<Mesh> BuildMesh(std::span<const Feature> features, const MeshOptions& options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  if (absl::Status status = plc::CheckMaxEdge(options); !status.ok()) return status;
  return options.dimension == 2 ? Build<2>(features, options) : Build<3>(features, options);
}

}  // namespace dynmesh
