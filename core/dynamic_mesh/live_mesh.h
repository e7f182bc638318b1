// DynamicMesh in 2D and 3D. An edit passes through: Plc validates the batch; a Transaction has
// FeatureTable apply the change to Refinement, the engine propagate it, DiffBuilder net the
// changes.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/dynamic_mesh/meshed_features.h"
#include "core/dynamic_mesh/progress_meter.h"
#include "core/plc/plc.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh {

template <int D>
class LiveMesh final : public DynamicMesh {
 public:
  // REQUIRES: ValidateOptions(options) is OK, the dimension is D; the bare box is within the
  // limits.
  explicit LiveMesh(const MeshOptions& options, const LiveMeshTuning& tuning = {});
  // The same as a status. REQUIRES: as above, without the limits.
  static absl::StatusOr<std::unique_ptr<DynamicMesh>> Make(const MeshOptions& options,
                                                           const ApplyOptions& apply);

  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const ApplyOptions& apply) override;
  void TakeBack(std::size_t revisions) override;
  void Settle() override { revocable_.clear(); }
  void ResumeAt(std::uint64_t revision) override {
    Settle();
    revision_ = revision;
  }
  absl::Status Validate(const EditBatch& batch) const override;
  Mesh Snapshot() const override;
  SimplexColumn Locate(std::span<const double> points) const override;
  std::vector<Feature> Features() const override { return mesh_.plc.Features(); }
  const MeshOptions& options() const override { return mesh_.options; }
  std::uint64_t revision() const override { return revision_; }
  MeshHash hash() const override { return mesh_.state->diffs.hash(); }
  MeshStats Stats() const override;
  AuditReport Audit() const override;
  // The first operation, in the order of time, in which the trace differs from that of `other`:
  // two lines, one for each; empty if the traces are equal. O(trace).
  std::string FirstDifference(const LiveMesh& other) const;
  // The first operation that, executed again, makes other things than its record says
  // (trace_audit.h); empty if there is none. O(trace).
  std::string FirstUnreproduced() const;

 private:
  struct Unbegun {};
  LiveMesh(Unbegun, const MeshOptions& options, const LiveMeshTuning& tuning)
      : mesh_(options, tuning) {}
  absl::StatusOr<plc::Delta<D>> Check(const EditBatch& batch, ProgressMeter& meter,
                                      Interrupt interrupt) const;
  void GiveMemoryBack(Interrupt interrupt);

  MeshedFeatures<D> mesh_;
  std::uint64_t revision_ = 0;
  std::vector<plc::Delta<D>> revocable_;  // of the last revisions, in this order
  // Memory is freed when there are at most so many operations.
  std::size_t give_back_at_ = std::numeric_limits<std::size_t>::max();
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
