// The kinds of dynamic mesh, dynamic and static.
#include <memory>
#include <utility>

#include "core/dynamic_mesh/build_mesh.h"
#include "core/dynamic_mesh/live_mesh.h"
#include "core/dynamic_mesh/live_quadtree.h"
#include "core/plc/labels.h"
#include "core/plc/messages.h"

namespace dynmesh {

absl::StatusOr<std::unique_ptr<DynamicMesh>> DynamicMesh::Create(const MeshOptions& options,
                                                                 const ApplyOptions& apply) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  if (options.kind == MeshKind::kQuadtree) {
    if (options.dimension == 2) return std::make_unique<LiveQuadtree<2>>(options);
    return std::make_unique<LiveQuadtree<3>>(options);
  }
  return options.dimension == 2 ? LiveMesh<2>::Make(options, apply)
                                : LiveMesh<3>::Make(options, apply);
}

namespace {

absl::StatusOr<Mesh> BuildUnlabelled(std::span<const Feature> features, const MeshOptions& options,
                                     const BuildOptions& build) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  const bool is_planar = options.dimension == 2;
  if (build.engine == BuildEngine::kSvr) {
    if (absl::Status status = CheckSvrOptions(options); !status.ok()) return status;
  }
  if (options.kind == MeshKind::kQuadtree) {
    return is_planar ? BuildQuadtree<2>(features, options, build)
                     : BuildQuadtree<3>(features, options, build);
  }
  if (absl::Status status = plc::CheckMaxEdge(options); !status.ok()) return status;
  return is_planar ? BuildDelaunay<2>(features, options, build)
                   : BuildDelaunay<3>(features, options, build);
}

}  // namespace

absl::StatusOr<Mesh> BuildMesh(std::span<const Feature> features, const MeshOptions& options,
                               const BuildOptions& build) {
  // Read before they may go.
  LabelColumn labels;
  BuildOptions with_labels = build;
  with_labels.features_read = [&] {
    labels = plc::LabelsOf(features);
    if (build.features_read) build.features_read();
  };
  const bool is_quadtree = options.kind == MeshKind::kQuadtree;
  absl::StatusOr<Mesh> mesh = BuildUnlabelled(features, options, with_labels);
  if (mesh.ok()) mesh->labels = is_quadtree ? plc::LabelsOf(features) : std::move(labels);
  return mesh;
}

}  // namespace dynmesh
