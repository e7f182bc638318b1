// A mesh that threads share: a mesher of this process with its replica, or the replica of a
// server's mesh alone. No Python types.
//
// Invariants:
//   1. edits are serialised. While one is computed, readers see the revision before it; the replica
//      then changes at once;
//   2. mesher and replica are at the same revision: an edit that the replica cannot follow is
//   undone;
//   3. a HeldColumn never changes.
//
// Thread-safe. The lock of edits is taken before that of the replica. Neither is ever waited for by
// a thread that a holder of the lock waits for: callers give up what they hold (Python's lock)
// before a call that may wait. A call from the progress callback of an edit that needs the mesher
// is an error, not a deadlock.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_SHARED_MESH_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_SHARED_MESH_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/python/module/held_column.h"
#include "core/base/mutex.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::python {

// Counts of one revision.
struct MeshNumbers {
  std::uint64_t revision = 0;
  MeshHash hash;
  std::size_t vertices = 0, simplices = 0;       // slots in use
  std::size_t vertex_slots = 0, cell_slots = 0;  // rows of columns
};

// The patch of the last edit, with what of the mesh belongs to it.
struct PatchColumns {
  MeshPatch patch;
  std::vector<Slot> added_corners;  // of patch.added_simplices
  // The faces of added simplices that they do not share with each other: simplex, the corner
  // opposite the face, the simplex beyond or -1.
  std::vector<Slot> boundary_faces;
};

// The mesh without free rows.
struct CompactColumns {
  CompactNumbering numbering;
  std::vector<double> points;
  std::vector<std::int32_t> cells;
  std::vector<RegionId> regions;
};

class SharedMesh {
 public:
  // A mesh in this process. Errors: those of DynamicMesh::Create.
  static absl::StatusOr<std::unique_ptr<SharedMesh>> Create(const MeshOptions& options);
  // The replica of a server's mesh. Errors: those of SlotMesh::FromMesh.
  static absl::StatusOr<std::unique_ptr<SharedMesh>> FromSnapshot(const Mesh& snapshot);

  // Of a mesh in this process. These wait for an edit of another thread. FAILED_PRECONDITION from
  // the progress callback of an edit of this mesh.

  // DynamicMesh::Apply, with the replica. `options` must have no commit. RESOURCE_EXHAUSTED if an
  // allocation fails; the mesher is then in no state, and all these are DATA_LOSS from then on.
  absl::StatusOr<MeshDiff> Edit(const EditBatch& batch, ApplyOptions options);
  absl::Status Validate(const EditBatch& batch);
  absl::StatusOr<std::vector<Feature>> Features();
  // The slot of a simplex around each of `points`; kNoSlot outside.
  absl::StatusOr<std::vector<Slot>> Locate(std::span<const double> points);
  absl::StatusOr<AuditReport> Audit();

  // Of a replica: SlotMesh::Apply or, if it `extends` the patch, Extend.
  absl::Status Apply(const MeshDiff& diff, bool extends);

  // Of the replica.

  int dimension() const { return dimension_; }
  const MeshOptions& options() const { return options_; }  // of a mesh in this process
  // Waits for a copy of some words at most.
  MeshNumbers numbers() const;
  // The lock of the replica, and the replica. It is held for the time of a diff, a transfer or a
  // copy of the mesh. The holder must not call this object.
  Mutex& mutex() const ABSL_LOCK_RETURNED(replica_mutex_) { return replica_mutex_; }
  const SlotMesh& replica() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_) { return replica_; }
  SlotMesh& replica() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_) { return replica_; }
  PatchColumns TakePatch() const;
  CompactColumns TakeCompact() const;

  // The columns of SlotMesh.

  HeldColumn<double> points() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<VertexId> ids() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<std::uint8_t> containing_dimensions() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<FeatureId> owners() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<Slot> cells() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<Slot> neighbours() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<RegionId> regions() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<Slot> subsegments() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<FeatureId> subsegment_owners() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<Slot> subfacets() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  HeldColumn<FeatureId> subfacet_owners() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);

 private:
  class Editing;

  SharedMesh(std::unique_ptr<DynamicMesh> mesher, SlotMesh replica);
  absl::Status ApplyLocked(const MeshDiff& diff, bool extends)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);
  void NoteNumbers() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_);

  const int dimension_;
  const MeshOptions options_;

  Mutex edit_mutex_;
  std::atomic<std::thread::id> editor_;                               // the thread that holds it
  std::unique_ptr<DynamicMesh> mesher_ ABSL_GUARDED_BY(edit_mutex_);  // null: a replica alone
  bool is_lost_ ABSL_GUARDED_BY(edit_mutex_) = false;                 // memory ran out

  mutable Mutex replica_mutex_;
  SlotMesh replica_ ABSL_GUARDED_BY(replica_mutex_);
  // Rows that changed, as far as there are copies that need them.
  RowLog vertex_log_ ABSL_GUARDED_BY(replica_mutex_), cell_log_ ABSL_GUARDED_BY(replica_mutex_),
      neighbour_log_ ABSL_GUARDED_BY(replica_mutex_),
      subsegment_log_ ABSL_GUARDED_BY(replica_mutex_),
      subfacet_log_ ABSL_GUARDED_BY(replica_mutex_);
  ColumnCopies<double> points_ ABSL_GUARDED_BY(replica_mutex_);
  ColumnCopies<VertexId> ids_ ABSL_GUARDED_BY(replica_mutex_);
  ColumnCopies<std::uint8_t> containing_dimensions_ ABSL_GUARDED_BY(replica_mutex_);
  ColumnCopies<FeatureId> owners_ ABSL_GUARDED_BY(replica_mutex_),
      subsegment_owners_ ABSL_GUARDED_BY(replica_mutex_),
      subfacet_owners_ ABSL_GUARDED_BY(replica_mutex_);
  ColumnCopies<Slot> cells_ ABSL_GUARDED_BY(replica_mutex_),
      neighbours_ ABSL_GUARDED_BY(replica_mutex_), subsegments_ ABSL_GUARDED_BY(replica_mutex_),
      subfacets_ ABSL_GUARDED_BY(replica_mutex_);
  ColumnCopies<RegionId> regions_ ABSL_GUARDED_BY(replica_mutex_);

  mutable Mutex numbers_mutex_;
  MeshNumbers numbers_ ABSL_GUARDED_BY(numbers_mutex_);
};

}  // namespace dynmesh::python

#endif  // DYNMESH_CLIENT_PYTHON_MODULE_SHARED_MESH_H_
