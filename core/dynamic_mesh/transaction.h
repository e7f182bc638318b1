// A batch on its way into the mesh: it begins, runs, and is accepted or rolled back.
//
//   plan           first attempt                       second attempt
//   kPropagate     in place                            from scratch, if only that can tell
//   kProbe         in place, unless much is stale      the same
//   kRebuild       from scratch
//
// In place the present state follows the change; to roll back is to undo it. From scratch a new
// state is built beside the present one; to roll back is to forget it. An attempt in place is
// undecided if a build from scratch is cheaper, or if it exceeds limits on the way, which depends
// on history. Then its state, partly old and partly new, is kept until the new one exists: undoing
// from there costs at most as much as the propagation so far.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_TRANSACTION_H_
#define DYNMESH_CORE_DYNAMIC_MESH_TRANSACTION_H_

#include <cstddef>
#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/dynamic_mesh/batch_run.h"
#include "core/dynamic_mesh/meshed_features.h"
#include "core/plc/delta.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

// For one batch.
template <int D>
class Transaction {
 public:
  // All must outlive this. `delta`: as Plc::Check returned it.
  Transaction(MeshedFeatures<D>& mesh, const plc::Delta<D>& delta, BatchRun<D>& run, Commit commit)
      : mesh_(mesh), delta_(delta), run_(run), commit_(commit) {}

  // The diff, and the mesh has the batch; or an error, and the mesh is as before.
  absl::StatusOr<MeshDiff> Run(Plan plan);

 private:
  // How an attempt has ended.
  enum class Outcome {
    kReady,      // diff_ is known
    kRefused,    // status_ says why
    kUndecided,  // only a build from scratch can tell
  };
  Outcome RunInPlace(Plan plan);
  Outcome RunFromScratch();
  std::size_t BeginInPlace();
  // What is counted of the state's refinement, beside the operations executed by all attempts.
  void CountWork(const MeshState<D>& state);
  Outcome DiffInPlace();
  Outcome Refuse(absl::Status status);
  void Accept();
  void RollBack();

  MeshedFeatures<D>& mesh_;
  const plc::Delta<D>& delta_;
  BatchRun<D>& run_;
  Commit commit_;
  std::uint64_t visited_cells_ = 0, visited_nodes_ = 0;  // of the present state, at the beginning
  std::size_t applied_ = 0;              // features of delta_ that the present state has
  std::unique_ptr<MeshState<D>> built_;  // the new state, from scratch
  MeshDiff diff_;
  absl::Status status_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_TRANSACTION_H_
