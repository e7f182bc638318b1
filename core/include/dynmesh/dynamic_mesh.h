// One dynamic mesh: features in, differences out.
//
// Invariants, at every revision:
//   1. the mesh is a function of options and feature set, bit for bit;
//   2. a batch that is refused, cancelled, vetoed, taken back or over a limit changes nothing;
//   3. every simplex is Delaunay, every input point a vertex, every input segment
//      a chain of edges, every simplex within the quality asked for.
//
// Thread-safety: thread-compatible. One thread may change a mesh while none reads.
#ifndef DYNMESH_DYNAMIC_MESH_H_
#define DYNMESH_DYNAMIC_MESH_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh {

// How far a batch is. Stages come in the order of their names, each once or not at all; within
// one `done` and the part done / total never fall, and its last words are done == total.
struct ApplyProgress {
  // What a batch goes through.
  enum class Stage : std::uint8_t {
    kValidate,  // features that change, with what depends on them, held against the others
    kRefine,    // operations run, of all that are known of: each may ask for more
    kDiff,      // what came and went; ends before `commit` is asked
  };
  Stage stage = Stage::kValidate;  // the one that is under way
  std::uint64_t done = 0;          // how much of it is
  std::uint64_t total = 0;         // 0: not known yet
};

// How a batch is applied. Nothing here changes the mesh that comes out.
struct ApplyOptions {
  // Polled between operations; when it turns true the batch is undone: CANCELLED.
  const std::atomic<bool>* cancelled = nullptr;
  // The same, for a second party: the caller's own reasons, beside its client's.
  const std::atomic<bool>* stopped = nullptr;
  // Between operations, some thousand times a second, threads that wait for the core have their
  // turn: for a process that answers others meanwhile. Changes nothing in what is done.
  bool shares_core = false;
  // Most operations that may be executed for the batch, those of attempts that were given up
  // included; 0: any number. A batch that needs more is undone: RESOURCE_EXHAUSTED (WORK_LIMIT).
  // From scratch a mesh takes 2 to 3 operations a vertex. How many an edit takes depends on what
  // is there, not on the clock; undoing takes about as many again.
  std::uint64_t max_operations = 0;
  // Asked once, with the diff as Apply would return it, when nothing else can fail any more and
  // before the mesh says that it is at the new revision: such as to write the batch down first.
  // Unless it answers OK the batch is undone, as if cancelled, and Apply returns its answer. An
  // empty batch is asked for, too. It must not use the mesh. May be null.
  std::function<absl::Status(const MeshDiff&)> commit;
  // The batch can be taken back later (DynamicMesh::TakeBack): for a caller that writes several
  // batches down at once. One that is applied without this settles those before it.
  bool revocable = false;
  // Told, on the thread of Apply, when a stage begins and ends and in between, between operations,
  // 50 ms apart or more. It must not use the mesh, and changes nothing in what is done. A batch
  // that is undone is not told of while it is. May be null.
  std::function<void(const ApplyProgress&)> progress;
};

// How large a mesh is, and what it takes.
struct MeshStats {
  std::uint64_t revision = 0;     // the present one
  std::uint64_t features = 0;     // that are present
  std::uint64_t vertices = 0;     // those of the domain box included
  std::uint64_t simplices = 0;    // triangles, in space tetrahedra
  std::uint64_t subsegments = 0;  // those of the domain box included
  std::uint64_t subfacets = 0;    // in space
  std::uint64_t operations = 0;   // in the trace
  std::uint64_t trace_bytes = 0;  // operations, registrations, requests, order
  std::uint64_t mesh_bytes = 0;   // vertices, triangulation, indices
};

// What an audit found.
struct AuditReport {
  std::vector<std::string> problems;  // empty: every invariant holds
  // Hashes the complete trace: equal to that of a run from scratch exactly if the two computations
  // are the same.
  MeshHash trace;
};

// A mesh that follows its features; see dynamic_mesh.h.
class DynamicMesh {
 public:
  // A mesh of the bare domain box, revision 0. INVALID_ARGUMENT for bad `options`. With max_edge
  // that is work, and RESOURCE_EXHAUSTED (VERTEX_LIMIT) if it asks for more vertices than there may
  // be; of `apply_options` what stops a batch stops it, too: CANCELLED.
  static absl::StatusOr<std::unique_ptr<DynamicMesh>> Create(
      const MeshOptions& options, const ApplyOptions& apply_options = {});

  virtual ~DynamicMesh() = default;

  // Makes the next revision from `batch`; an empty batch makes none (the diff is
  // then empty, from = to). Expected time O(m_f lg L/s) for the m_f vertices that
  // the features of the batch carry. Errors name the features (error.h); the mesh is then as it
  // was. `apply_options` limits and follows it.
  virtual absl::StatusOr<MeshDiff> Apply(const EditBatch& batch,
                                         const ApplyOptions& apply_options = {}) = 0;

  // Undoes the last `revisions` of those that revocable batches made since Settle, the last one
  // first: mesh, trace and revision are those of before. Expected time as that of these batches;
  // O(what they changed) memory is held for it until Settle. REQUIRES: there are so many.
  virtual void TakeBack(std::size_t revisions) = 0;
  // The batches applied so far stay.
  virtual void Settle() = 0;

  // Says that the mesh as it is now is that `revision`, and settles what was applied; nothing but
  // the number changes. For a mesh that is made again from the features that it had.
  virtual void ResumeAt(std::uint64_t revision) = 0;

  // Would Apply accept the features of `batch`? Of limits only what is told without meshing is
  // looked at: regions with a target, or features so near each other, that take more than
  // max_vertices whatever else there is (RESOURCE_EXHAUSTED, VERTEX_LIMIT, with their ids). No
  // change.
  virtual absl::Status Validate(const EditBatch& batch) const = 0;

  // The whole mesh, O(size).
  virtual Mesh Snapshot() const = 0;

  // For each of n `points` (n x dimension coordinates), the canonical ids of a simplex
  // that holds it: n x (dimension + 1) ids, all 0 where a point is outside the domain.
  virtual SimplexColumn Locate(std::span<const double> points) const = 0;

  // The features present, by id.
  virtual std::vector<Feature> Features() const = 0;

  // As the mesh was created.
  virtual const MeshOptions& options() const = 0;
  // How many batches made it what it is; see ResumeAt.
  virtual std::uint64_t revision() const = 0;
  // Of the mesh as it is, kept up to date: O(1).
  virtual MeshHash hash() const = 0;
  // Counts and memory, O(1).
  virtual MeshStats Stats() const = 0;

  // Checks every invariant of trace and mesh, O(size). For tests and support.
  virtual AuditReport Audit() const = 0;
};

// The static path: the same mesh as a DynamicMesh of `options` with these `features`, without a
// trace, hence faster. Revision 1 (0 if there is no feature). Errors are those of Create and Apply.
absl::StatusOr<Mesh> BuildMesh(std::span<const Feature> features, const MeshOptions& options);

}  // namespace dynmesh

#endif  // DYNMESH_DYNAMIC_MESH_H_
