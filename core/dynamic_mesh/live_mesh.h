// DynamicMesh in the plane and in space. One edit, walked: Plc validates the batch, FeatureTable
// hands the change to Refinement, the engine propagates it, DiffBuilder nets what came
// and went. The only place that picks an engine.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_

#include <functional>
#include <limits>
#include <memory>
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

// How a LiveMesh goes about its work; none of it changes a bit of any result.
struct LiveMeshTuning {
  RebuildThresholds rebuild;
  // From scratch: read neighbourhoods off the growing triangulation.
  bool global_neighbourhoods = true;
  VertexHash vertex_hash = &VertexIdAt;
  // Lesser ones are for tests.
  sac::EngineLimits engine_limits = {};
  std::size_t most_tetrahedra = 0;  // 0: as many as it can
};

// How a run of what is stale has ended.
enum class Ended {
  kDone,
  kCancelled,
  kOverLimits,  // of the mesh
  kOverWork,    // more operations than the batch may execute
  kTooDear,     // it is cheaper to build anew
};

template <int D>
class LiveMesh final : public DynamicMesh {
 public:
  // REQUIRES: ValidateOptions(options) is OK, the dimension is D; the bare box is within the
  // limits.
  explicit LiveMesh(const MeshOptions& options, const LiveMeshTuning& tuning = {});
  // The same, or why not. REQUIRES: as above but for limits.
  static absl::StatusOr<std::unique_ptr<DynamicMesh>> Make(const MeshOptions& options,
                                                           const ApplyOptions& apply);

  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const ApplyOptions& apply) override;
  // The same, asked whether to go on before each operation.
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

 private:
  using Refinement = meshing::Refinement<D, sac::Engine>;
  struct Unbegun {};

  LiveMesh(Unbegun, const MeshOptions& options, const LiveMeshTuning& tuning);
  // Meshes the bare box. False if that was interrupted: then it is no mesh.
  template <class Interrupt>
  bool Begin(Interrupt interrupt);

  // All that is computed from the features.
  struct State {
    State(const MeshOptions& options, const LiveMeshTuning& tuning)
        : diffs(tuning.vertex_hash),
          refinement(options, tuning.global_neighbourhoods ? &diffs.triangulation() : nullptr) {
      if (!tuning.global_neighbourhoods) refinement.ResetToDomain(&diffs.triangulation());
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

  // Whether the batch with that diff, but for revisions, may come into effect; completes it.
  using Commit = absl::FunctionRef<absl::Status(MeshDiff&)>;

  // A batch under way.
  template <class Interrupt>
  struct Task {
    const plc::Delta<D>& delta;
    ProgressMeter& meter;
    Interrupt& cancelled;
    Commit commit;
    std::uint64_t most_operations;  // to be executed
    std::uint64_t executed = 0;     // by propagations and builds that are over
  };

  template <class Interrupt>
  absl::StatusOr<MeshDiff> ApplyWith(const EditBatch& batch, const ApplyOptions& apply,
                                     Interrupt cancelled);
  // A state of the features that `all` adds, and its mesh.
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
  std::vector<plc::Delta<D>> revocable_;  // made the last revisions, in this order
  // Operations from which down memory is given back.
  std::size_t give_back_at_ = std::numeric_limits<std::size_t>::max();
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIVE_MESH_H_
