// The static path: no trace, neighbourhoods read off one growing triangulation.
#include <memory>

#include "core/dynamic_mesh/planar_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh {

absl::StatusOr<Mesh> BuildMesh(std::span<const Feature> features, const MeshOptions& options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  plc::Plc2 plc(options);
  const absl::StatusOr<plc::Delta> delta = plc.Check(plc::Edits::Adding(features));
  if (!delta.ok()) return delta.status();

  DiffBuilder diffs;
  FeatureTable table;
  meshing::Refinement<sac::UntracedEngine> refinement(options, &diffs.triangulation());
  refinement.Reserve(delta->added_points.size());
  table.Apply(*delta, refinement);
  const std::uint64_t most = options.limits.max_vertices;
  refinement.Propagate(
      [&] { return refinement.vertex_count() > most || refinement.hit_depth_limit(); });
  if (refinement.hit_depth_limit()) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     "a segment would have to be halved more often than max_depth allows",
                     {reason::kDepthLimit, {}, {}});
  }
  if (refinement.vertex_count() > most) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        "the mesh would have more than max_vertices = " + std::to_string(most) + " vertices",
        {reason::kVertexLimit, {}, {}});
  }
  Mesh mesh = diffs.Begin(refinement, table);
  if (absl::Status status = diffs.RegionStatus(); !status.ok()) return status;
  mesh.revision = features.empty() ? 0 : 1;
  return mesh;
}

}  // namespace dynmesh
