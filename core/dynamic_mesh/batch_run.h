// The runs of one batch: propagations and builds from scratch, which share its limits, its progress
// and its interrupt.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_BATCH_RUN_H_
#define DYNMESH_CORE_DYNAMIC_MESH_BATCH_RUN_H_

#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/dynamic_mesh/meshed_features.h"
#include "core/dynamic_mesh/progress_meter.h"
#include "core/dynamic_mesh/rebuild_choice.h"
#include "core/plc/delta.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

// How a run has ended.
enum class Ended {
  kDone,
  kCancelled,
  kOverLimits,  // of the mesh
  kOverWork,    // more operations than the batch may execute
  kTooDear,     // a build from scratch is expected to be cheaper
};

// A new state and its mesh.
template <int D>
struct Built {
  std::unique_ptr<MeshState<D>> state;
  Mesh mesh;
  double diff_microseconds = 0;
};

template <int D>
struct BatchRun {
  // Runs stale operations until there are none, or there is a reason to stop. `plan`: kRebuild for
  // a fresh state, which is never stopped as kTooDear, since there is no alternative.
  Ended Propagate(MeshState<D>& state, Plan plan);
  // A state of the features that `all` adds, `features` in number. Errors: those of StatusOf, and
  // labels or names that cannot be distinguished.
  absl::StatusOr<Built<D>> Build(const plc::Delta<D>& all, std::size_t features);
  // The error of a run that was stopped; OK if it was not.
  absl::Status StatusOf(Ended ended, const MeshState<D>& state) const;

  const MeshOptions& options;
  const LiveMeshTuning& tuning;
  ProgressMeter& meter;
  Interrupt interrupt;
  std::uint64_t most_operations;  // of the batch
  std::uint64_t executed = 0;     // by all its runs
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_BATCH_RUN_H_
