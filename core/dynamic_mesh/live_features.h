// What all kinds of dynamic mesh have in common: Plc validates a batch, a subclass runs the change
// that it makes, the result is a revision, and the last revisions can be taken back. Labels are
// kept here: no mesh depends on them.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIVE_FEATURES_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIVE_FEATURES_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/dynamic_mesh/progress_meter.h"
#include "core/plc/delta.h"
#include "core/plc/labels.h"
#include "core/plc/plc.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh {

// Polled between steps of some microseconds. True: stop.
using Interrupt = absl::FunctionRef<bool()>;
constexpr bool Never() { return false; }

// Completes the diff of a batch, but for the revisions, and decides whether the batch takes effect.
using Commit = absl::FunctionRef<absl::Status(MeshDiff&)>;

// `interrupted` must outlive the result; null: Never.
Interrupt InterruptOf(const std::function<bool()>& interrupted);
// 0: no limit.
constexpr std::uint64_t MostOperations(std::uint64_t max_operations) {
  return max_operations != 0 ? max_operations : std::numeric_limits<std::uint64_t>::max();
}

// The change that the batch makes, if it is valid and the points alone are within the limits.
template <int D>
absl::StatusOr<plc::Delta<D>> CheckBatch(const plc::Plc<D>& plc, const plc::Edits& batch,
                                         const MeshOptions& options, ProgressMeter& meter,
                                         Interrupt interrupt);

// The same for a batch that adds `features` to none. What `valid` proves is not validated again; it
// may be null.
template <int D>
absl::StatusOr<plc::Delta<D>> CheckFeatures(const plc::Plc<D>& plc,
                                            std::span<const Feature> features,
                                            const MeshOptions& options, const ValidFeatures* valid,
                                            ProgressMeter& meter, Interrupt interrupt);

template <int D>
class LiveFeatures : public DynamicMesh {
 public:
  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const ApplyOptions& apply) final;
  void TakeBack(std::size_t revisions) final;
  void SettleAllBut(std::size_t revisions) final;
  void ResumeAt(std::uint64_t revision) final {
    Settle();
    revision_ = revision;
  }
  absl::Status Validate(const EditBatch& batch) const final;
  std::vector<Feature> Features() const final;
  std::uint64_t revision() const final { return revision_; }

 protected:
  struct Batch {
    ProgressMeter& meter;
    Interrupt interrupt;
    std::uint64_t most_operations;
  };

  virtual plc::Plc<D>& plc() = 0;
  virtual const plc::Plc<D>& plc() const = 0;
  // Runs the change, as Plc::Check returned it. The diff, and mesh and Plc have the batch; or an
  // error, and they are as before.
  virtual absl::StatusOr<MeshDiff> Run(const plc::Delta<D>& delta, const Batch& batch,
                                       Commit commit) = 0;
  // Takes a change back. The Plc has the former features.
  virtual void Undo(const plc::Delta<D>& delta) = 0;
  // Frees memory if much is free room. If it is interrupted, nothing changes.
  virtual void GiveMemoryBack(Interrupt interrupt) = 0;

  // Of the features present.
  const plc::LabelTable& labels() const { return labels_; }

 private:
  struct Revocable {
    plc::Delta<D> delta;
    plc::LabelChanges labels;
  };

  std::uint64_t revision_ = 0;
  plc::LabelTable labels_;
  std::deque<Revocable> revocable_;  // the last revisions, in this order
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIVE_FEATURES_H_
