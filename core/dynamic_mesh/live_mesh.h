// DynamicMesh in 2D and 3D. An edit passes through: Plc validates the batch, FeatureTable applies
// the change to Refinement, the engine propagates it, DiffBuilder nets the changes. The only place
// that chooses an engine.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/dynamic_mesh/diff_builder.h"
#include "core/dynamic_mesh/feature_table.h"
#include "core/dynamic_mesh/progress_meter.h"
#include "core/dynamic_mesh/rebuild_choice.h"
#include "core/meshing/refinement.h"
#include "core/plc/plc.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh {

// Tuning of a LiveMesh; it changes no bit of any result.
struct LiveMeshTuning {
  RebuildThresholds rebuild;
  // From scratch: read neighbourhoods from the growing triangulation.
  bool global_neighbourhoods = true;
  VertexHash vertex_hash = &VertexIdAt;
  // Smaller limits are for tests.
  sac::EngineLimits engine_limits = {};
  std::size_t most_tetrahedra = 0;  // 0: no limit but the indices
};

// How a propagation or build has ended.
enum class Ended {
  kDone,
  kCancelled,
  kOverLimits,  // of the mesh
  kOverWork,    // more operations than the batch may execute
  kTooDear,     // a build from scratch is cheaper
};

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
  // The same; polls `cancelled` before each operation.
  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const std::function<bool()>& cancelled);

  void TakeBack(std::size_t revisions) override;
  void Settle() override { revocable_.clear(); }
  void ResumeAt(std::uint64_t revision) override {
    Settle();
    revision_ = revision;
  }
  absl::Status Validate(const EditBatch& batch) const override;
  Mesh Snapshot() const override;
  SimplexColumn Locate(std::span<const double> points) const override;
  std::vector<Feature> Features() const override { return plc_.Features(); }
  const MeshOptions& options() const override { return options_; }
  std::uint64_t revision() const override { return revision_; }
  MeshHash hash() const override { return state_->diffs.hash(); }
  MeshStats Stats() const override;
  AuditReport Audit() const override;
  // The first operation, in the order of time, in which the trace differs from that of `other`:
  // two lines, one for each; empty if the traces are equal. O(trace).
  std::string FirstDifference(const LiveMesh& other) const;

 private:
  using Refinement = meshing::Refinement<D, sac::Engine>;
  struct Unbegun {};

  LiveMesh(Unbegun, const MeshOptions& options, const LiveMeshTuning& tuning);
  // Meshes the bare box. False if it was interrupted: the state is then no mesh.
  template <class Interrupt>
  bool Begin(Interrupt interrupt);

  // Everything computed from the features.
  struct State {
    State(const MeshOptions& options, const LiveMeshTuning& tuning)
        : diffs(tuning.vertex_hash),
          refinement(options, tuning.global_neighbourhoods ? &diffs.triangulation() : nullptr) {
      if (!tuning.global_neighbourhoods) refinement.complex().ResetToDomain(&diffs.triangulation());
      refinement.engine().set_limits(tuning.engine_limits);
      if constexpr (D == 3) {
        if (tuning.most_tetrahedra > 0) {
          diffs.triangulation().set_most_simplices(tuning.most_tetrahedra);
        }
      }
    }
    DiffBuilder<D> diffs;
    FeatureTable<D> features;
    Refinement refinement;
  };

  // Completes the diff of a batch, but for the revisions, and decides whether the batch takes
  // effect.
  using Commit = absl::FunctionRef<absl::Status(MeshDiff&)>;

  // A running batch.
  template <class Interrupt>
  struct Task {
    const plc::Delta<D>& delta;
    ProgressMeter& meter;
    Interrupt& cancelled;
    Commit commit;
    std::uint64_t most_operations;  // of the batch
    std::uint64_t executed = 0;     // by finished propagations and builds
  };

  template <class Interrupt>
  absl::StatusOr<MeshDiff> ApplyWith(const EditBatch& batch, const ApplyOptions& apply,
                                     Interrupt cancelled);
  // A state of the features that `all` adds, with its mesh.
  struct Built {
    std::unique_ptr<State> state;
    Mesh mesh;
    double diff_microseconds = 0;
  };
  template <class Job>
  absl::StatusOr<Built> Build(const plc::Delta<D>& all, std::size_t features, Job& job);
  template <class Job>
  Ended Run(State& state, Job& job, Plan plan);
  template <class Job>
  absl::Status StatusOf(Ended ended, const Job& job, const State& state) const;
  template <class Job>
  std::size_t HandOver(Job& job);
  template <class Job>
  absl::StatusOr<MeshDiff> Propagate(Job& job, Plan plan);
  template <class Job>
  absl::StatusOr<MeshDiff> Finish(Job& job);
  template <class Job>
  absl::StatusOr<MeshDiff> Rebuild(Job& job);
  void Undo(const plc::Delta<D>& delta);
  template <class Interrupt>
  void ReplaceState(Interrupt cancelled);
  void BuildPresent();
  template <class Interrupt>
  void GiveMemoryBack(Interrupt cancelled);

  const MeshOptions options_;
  const LiveMeshTuning tuning_;
  plc::Plc<D> plc_;
  std::unique_ptr<State> state_;
  std::uint64_t revision_ = 0;
  std::vector<plc::Delta<D>> revocable_;  // of the last revisions, in this order
  // Memory is freed when there are at most so many operations.
  std::size_t give_back_at_ = std::numeric_limits<std::size_t>::max();
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
