#include "server/meshes/revert_plan.h"

#include <utility>

#include "core/mesh_data/feature_set.h"
#include "proto/codec/edit_codec.h"
#include "server/base/mesh_name.h"

namespace dynmesh::server {
namespace {

struct Comparison {
  std::vector<Feature> old;  // by id
  std::uint64_t present = 0;
  EditBatch edits;  // from that revision's features to `old`
};

}  // namespace

RevertPlan PlanRevert(const MeshHost& host, std::uint64_t revision,
                      std::shared_ptr<const std::atomic<bool>> cancelled) {
  RevertPlan plan;
  plan.job.content = FingerprintOfRevert(revision);
  plan.job.cancelled = cancelled;
  const MeshHistory* const history = host.history();
  const Head head = host.head();
  auto span = history == nullptr ? absl::StatusOr<MeshHistory::Span>(NoHistoryError(host.id()))
                                 : history->Between(revision, head.revision, head, cancelled.get());
  if (!span.ok()) {
    plan.job.make = [error = span.status()](const DynamicMesh&) -> absl::StatusOr<EditBatch> {
      return error;
    };
    return plan;
  }
  auto found = std::make_shared<Comparison>();
  found->present = head.revision;
  if (revision < head.revision) {
    found->edits = mesh_data::EditsBetween(span->to.features, span->from.features);
  }
  plan.weight = codec::Weight(found->edits);
  found->old = std::move(span->from.features);
  if (span->from_bits == kMeshBits) plan.job.expected_hash = span->from.hash;
  plan.job.make = [found](const DynamicMesh& mesh) -> absl::StatusOr<EditBatch> {
    if (mesh.revision() == found->present) return std::move(found->edits);
    return mesh_data::EditsBetween(mesh.Features(), found->old);
  };
  return plan;
}

}  // namespace dynmesh::server
