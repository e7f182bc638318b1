// The static path: no trace, neighbourhoods read off one growing triangulation.
#include <memory>

#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/planar_mesh.h"

namespace dynmesh {

absl::StatusOr<Mesh> BuildMesh(std::span<const Feature> features, const MeshOptions& options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  plc::Plc2 plc(options);
  const absl::StatusOr<plc::Delta<2>> delta = plc.Check(plc::Edits::Adding(features));
  if (!delta.ok()) return delta.status();

  DiffBuilder diffs;
  FeatureTable table;
  meshing::Refinement<2, sac::UntracedEngine> refinement(options, &diffs.triangulation());
  refinement.Reserve(delta->added_points.size());
  table.Apply(*delta, refinement);
  refinement.Propagate([&] { return IsOverLimits(refinement, options.limits); });
  if (absl::Status status = LimitsStatus(refinement, options.limits); !status.ok()) return status;
  Mesh mesh = diffs.Begin(refinement, table);
  if (absl::Status status = diffs.RegionStatus(); !status.ok()) return status;
  mesh.revision = features.empty() ? 0 : 1;
  return mesh;
}

}  // namespace dynmesh
