// A Delaunay mesh as DynamicMesh, in 2D and 3D. An edit passes through: Plc validates the batch
// (live_features.h); a Transaction has FeatureTable apply the change to Refinement, the engine
// propagate it, DiffBuilder net the changes.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/dynamic_mesh/live_features.h"
#include "core/dynamic_mesh/live_mesh_tuning.h"
#include "core/plc/plc.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh {

template <int D>
struct MeshedFeatures;

template <int D>
class LiveMesh final : public LiveFeatures<D> {
 public:
  // REQUIRES: ValidateOptions(options) is OK, the dimension is D; the bare box is within the
  // limits.
  explicit LiveMesh(const MeshOptions& options, const LiveMeshTuning& tuning = {});
  ~LiveMesh() override;
  // The same as a status. REQUIRES: as above, without the limits.
  static absl::StatusOr<std::unique_ptr<DynamicMesh>> Make(const MeshOptions& options,
                                                           const ApplyOptions& apply);

  Mesh Snapshot() const override;
  SimplexColumn Locate(std::span<const double> points) const override;
  std::vector<double> LeafSides(std::span<const double> /*points*/) const override { return {}; }
  const MeshOptions& options() const override;
  MeshHash hash() const override;
  MeshStats Stats() const override;
  AuditReport Audit() const override;
  // The first operation, in the order of time, in which the trace differs from that of `other`:
  // two lines, one for each; empty if the traces are equal. O(trace).
  std::string FirstDifference(const LiveMesh& other) const;
  // The first operation that, executed again, makes other things than its record says
  // (trace_audit.h); empty if there is none. O(trace).
  std::string FirstUnreproduced() const;

 protected:
  plc::Plc<D>& plc() override;
  const plc::Plc<D>& plc() const override;
  absl::StatusOr<MeshDiff> Run(const plc::Delta<D>& delta,
                               const typename LiveFeatures<D>::Batch& batch,
                               Commit commit) override;
  void Undo(const plc::Delta<D>& delta) override;
  void GiveMemoryBack(Interrupt interrupt) override;

 private:
  struct Unbegun {};
  LiveMesh(Unbegun, const MeshOptions& options, const LiveMeshTuning& tuning);

  // Behind a pointer: users of this header need not know the mesher.
  const std::unique_ptr<MeshedFeatures<D>> mesh_;
  // Memory is freed when there are at most so many operations.
  std::size_t give_back_at_ = std::numeric_limits<std::size_t>::max();
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
