#include "client/cli/check_revision.h"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

absl::Status SameHash(std::string_view what, const MeshHash& expected, const MeshHash& found) {
  if (expected == found) return absl::OkStatus();
  return absl::InternalError(text::Concat(what, " has hash ", found.ToHex(), " where ",
                                          expected.ToHex(), " was expected"));
}

absl::Status Clean(std::string_view what, const AuditReport& audit) {
  if (audit.problems.empty()) return absl::OkStatus();
  return absl::InternalError(text::Concat("the audit of ", what, " finds ", audit.problems.size(),
                                          " problem(s), first: ", audit.problems.front()));
}

absl::Status Failed(std::string_view what, const absl::Status& status) {
  return absl::InternalError(text::Concat(what, " fails: ", text::View(status.message())));
}

}  // namespace

absl::Status CheckRevision(const DynamicMesh& mesh, const SlotMesh& replica) {
  const AuditReport audit = mesh.Audit();
  if (auto s = Clean("the mesh", audit); !s.ok()) return s;
  const Mesh snapshot = mesh.Snapshot();
  if (auto s = SameHash("the snapshot", mesh.hash(), ComputeHash(snapshot)); !s.ok()) return s;
  if (auto s = SameHash("the replica", mesh.hash(), replica.hash()); !s.ok()) return s;

  std::vector<Feature> features = mesh.Features();
  // In another order than the edits: the mesh must not depend on the history.
  std::reverse(features.begin(), features.end());
  const absl::StatusOr<Mesh> built = BuildMesh(features, mesh.options());
  if (!built.ok()) return Failed("the static run", built.status());
  if (auto s = SameHash("the static run's mesh", mesh.hash(), built->hash); !s.ok()) return s;

  const absl::StatusOr<std::unique_ptr<DynamicMesh>> fresh = DynamicMesh::Create(mesh.options());
  if (!fresh.ok()) return Failed("a fresh mesh", fresh.status());
  EditBatch batch;
  for (const Feature& feature : features) batch.push_back(Edit::Add(feature));
  const absl::StatusOr<MeshDiff> diff = (*fresh)->Apply(batch);
  if (!diff.ok()) return Failed("the from-scratch run", diff.status());
  if (auto s = SameHash("the from-scratch mesh", mesh.hash(), (*fresh)->hash()); !s.ok()) return s;
  const AuditReport fresh_audit = (*fresh)->Audit();
  if (auto s = Clean("the from-scratch mesh", fresh_audit); !s.ok()) return s;
  return SameHash("the from-scratch trace", audit.trace, fresh_audit.trace);
}

}  // namespace dynmesh::cli
