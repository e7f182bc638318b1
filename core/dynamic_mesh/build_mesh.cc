#include "core/dynamic_mesh/build_mesh.h"

#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/live_mesh.h"
#include "core/plc/messages.h"

namespace dynmesh {

template <int D>
absl::StatusOr<Mesh> BuildDelaunay(std::span<const Feature> features, const MeshOptions& options) {
  plc::Plc<D> plc(options);
  const absl::StatusOr<plc::Delta<D>> delta = plc.Check(plc::Edits::Adding(features));
  if (!delta.ok()) return delta.status();
  if (delta->added_points.size() > options.limits.max_vertices) {
    return VertexLimitError(options);
  }

  DiffBuilder<D> diffs;
  FeatureTable<D> table;
  meshing::Refinement<D, sac::UntracedEngine> refinement(options, &diffs.triangulation());
  refinement.Reserve(delta->added_points.size());
  table.Apply(*delta, refinement);
  refinement.Propagate([&] { return IsOverLimits(refinement, options.limits.max_vertices); });
  if (absl::Status status = LimitsStatus(refinement, options); !status.ok()) return status;
  Mesh mesh = diffs.Begin(refinement, table);
  if (absl::Status status = diffs.RegionStatus(); !status.ok()) return status;
  if (absl::Status status = diffs.NameStatus(refinement, table); !status.ok()) return status;
  mesh.revision = features.empty() ? 0 : 1;
  return mesh;
}

template absl::StatusOr<Mesh> BuildDelaunay<2>(std::span<const Feature>, const MeshOptions&);
template absl::StatusOr<Mesh> BuildDelaunay<3>(std::span<const Feature>, const MeshOptions&);

}  // namespace dynmesh
