// One dynamic mesh: features in, diffs out.
//
//   dynmesh::MeshOptions options;                       // 2D, the unit square
//   auto mesh = dynmesh::DynamicMesh::Create(options);  // check mesh.ok()
//   auto diff = (*mesh)->Apply({dynmesh::Edit::Add(dynmesh::Feature::Point(1, 0.5, 0.5))});
//   if (!diff.ok()) std::cerr << diff.status() << "\n";  // the mesh is as it was
//   dynmesh::Mesh whole = (*mesh)->Snapshot();
//
// Invariants, at every revision:
//   1. the mesh is a function of options and feature set, bit for bit; labels of features affect
//      nothing but Mesh::labels;
//   2. a batch that fails, is cancelled, vetoed or taken back changes nothing;
//   3. every simplex is Delaunay, every input point is a vertex, every input segment is a chain of
//      edges, every simplex meets the quality bound (exceptions: quality.h, SimplexVerdict). Of a
//      quadtree (MeshKind): the guarantees of quadtree.h.
//
// Thread-safety: thread-compatible. A call that changes the mesh excludes all other calls.
#ifndef DYNMESH_DYNAMIC_MESH_H_
#define DYNMESH_DYNAMIC_MESH_H_

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
#include "dynmesh/valid_features.h"

namespace dynmesh {

// Progress of a batch. Stages come in the order of their declaration, each at most once. Within a
// stage, `done` and done / total never decrease, and the last report has done == total.
struct ApplyProgress {
  // The stages of a batch.
  enum class Stage : std::uint8_t {
    kValidate,  // checks the features that change, and those that depend on them, against the
                // others
    kRefine,    // runs operations; total: those known so far (an operation may create others)
    kDiff,      // computes the diff; ends before `commit` is called
  };
  Stage stage = Stage::kValidate;  // the current one
  std::uint64_t done = 0;          // units of it that are done
  std::uint64_t total = 0;         // all its units; 0: not known yet
};

// How a batch is applied. No option changes the resulting mesh.
struct ApplyOptions {
  // Called on the thread of Apply before each operation and at least once in 1,024 shorter steps (a
  // feature checked, a point inserted, a row compared), so every few microseconds: it must be
  // cheap. Once it returns true, the batch is undone (CANCELLED). Not called while a batch is being
  // undone. After `commit` has succeeded it may be called while memory is freed; if it then returns
  // true, a later batch frees it. It must not use the mesh. Null: never interrupted.
  //
  //   options.interrupted = [&stop] { return stop.load(std::memory_order_relaxed); };
  std::function<bool()> interrupted = nullptr;
  // The most operations to execute for the batch, those of abandoned attempts included; 0: no
  // limit. A batch that needs more is undone: RESOURCE_EXHAUSTED (WORK_LIMIT). Building from
  // scratch takes 2 to 3 operations a vertex; an edit is not built anew if that would be too many.
  // The count of an edit depends on the mesh, not on the clock. Undoing takes about as many again.
  std::uint64_t max_operations = 0;
  // Called once, with the diff that Apply would return, after all other checks and before the new
  // revision is visible. For example to write the batch to a journal. If it returns an error the
  // batch is undone, and Apply returns that error. Called for an empty batch, too. It must not use
  // the mesh. May be null.
  std::function<absl::Status(const MeshDiff&)> commit = nullptr;
  // The batch can be undone later (DynamicMesh::TakeBack). For a caller that writes several batches
  // to a journal at once. Applying a batch without it settles all batches before.
  bool revocable = false;
  // Called on the thread of Apply: when a stage begins, when it ends, and between operations at
  // intervals of 50 ms or more. Not called while a batch is being undone. It must not use the mesh.
  // May be null.
  std::function<void(const ApplyProgress&)> progress = nullptr;
};

// Size and memory of a mesh.
struct MeshStats {
  std::uint64_t revision = 0;     // the current one
  std::uint64_t features = 0;     // features present
  std::uint64_t vertices = 0;     // domain box included
  std::uint64_t simplices = 0;    // triangles, in 3D tetrahedra
  std::uint64_t subsegments = 0;  // domain box included
  std::uint64_t subfacets = 0;    // 3D only; 0 in 2D
  std::uint64_t operations = 0;   // operations in the trace
  std::uint64_t trace_bytes = 0;  // of operations, registrations, requests, order
  std::uint64_t mesh_bytes = 0;   // of vertices, triangulation, indices
};

// The result of an audit.
struct AuditReport {
  std::vector<std::string> problems;  // empty: every invariant holds
  // A hash of the complete trace. It equals that of a run from scratch iff the two computations are
  // the same.
  MeshHash trace;
};

// A mesh that follows its features; see dynamic_mesh.h. Errors are absl statuses with a reason and
// the features involved (error.h, with the status code of each reason).
class DynamicMesh {
 public:
  // Makes a mesh of the bare domain box, revision 0. Of `apply_options`, interrupted and
  // max_operations apply. Errors: INVALID_ARGUMENT (BAD_OPTION) for bad `options`;
  // RESOURCE_EXHAUSTED if max_edge needs more than `options`.limits (VERTEX_LIMIT), indices
  // (SIZE_LIMIT) or max_operations (WORK_LIMIT) allow; CANCELLED.
  static absl::StatusOr<std::unique_ptr<DynamicMesh>> Create(
      const MeshOptions& options, const ApplyOptions& apply_options = {});

  virtual ~DynamicMesh() = default;

  // Makes the next revision from `batch`, as `apply_options` say, and returns the diff. An empty
  // batch makes none: its diff is empty and has from_revision == to_revision.
  //
  // Expected time O(m_f lg(L / s)); exceptions: docs/engine.md. m_f vertices lie on the features of
  // the batch, L is the side of the domain, s the least distance of features that do not touch.
  //
  // On an error the mesh is as it was. Errors (reasons: error.h):
  //   * INVALID_ARGUMENT: a feature or edit is malformed by itself;
  //   * NOT_FOUND: it edits an absent feature; ALREADY_EXISTS: it adds a present id;
  //   * FAILED_PRECONDITION: features conflict, or need absent points;
  //   * RESOURCE_EXHAUSTED: a limit of MeshOptions, of indices or of `apply_options` is exceeded;
  //   * CANCELLED: by `apply_options`; any status that ApplyOptions::commit returns.
  virtual absl::StatusOr<MeshDiff> Apply(const EditBatch& batch,
                                         const ApplyOptions& apply_options = {}) = 0;

  // Undoes the last `revisions` revisions, the latest first. Mesh, labels, trace and revision are
  // then those of before. Expected time: that of the undone batches. The memory for it, O(what the
  // batches changed), is held until they are settled. REQUIRES: the last `revisions` revisions were
  // applied as revocable and are not settled.
  virtual void TakeBack(std::size_t revisions) = 0;
  // Makes all revisions permanent but the last `revisions`, and frees the memory for undoing them:
  // TakeBack can no longer undo them. O(number of those settled). REQUIRES: as TakeBack.
  virtual void SettleAllBut(std::size_t revisions) = 0;
  // Makes all revisions so far permanent.
  void Settle() { SettleAllBut(0); }

  // Sets the revision number to `revision` and settles. Nothing else changes. For a mesh that was
  // rebuilt from stored features.
  virtual void ResumeAt(std::uint64_t revision) = 0;

  // Checks without a change whether Apply would accept the features of `batch`; returns Apply's
  // error. Limits are checked only where that needs no meshing: RESOURCE_EXHAUSTED (VERTEX_LIMIT),
  // with feature ids, if sizing regions or features close to each other certainly need more than
  // max_vertices.
  virtual absl::Status Validate(const EditBatch& batch) const = 0;

  // The whole mesh, O(size).
  virtual Mesh Snapshot() const = 0;

  // For each of n `points` (n x dimension coordinates), the vertex ids of the simplex that contains
  // it, in canonical order: n x (dimension + 1) ids. All are 0 for a point outside the domain. Of
  // several simplices, at a point on a common side, edge or corner, the one whose ids are the least
  // in lexicographical order: a function of the mesh and the point.
  // Of a quadtree: the vertex of the leaf that contains the point, and zeros; of several leaves the
  // one with the greatest coordinates.
  virtual SimplexColumn Locate(std::span<const double> points) const = 0;

  // Of a quadtree: the side of the leaf that Locate finds for each of `points`, 0 where there is
  // none. It bounds the local feature size: FeatureSizeIn, quadtree.h. O(depth) a point. Empty for
  // other kinds.
  virtual std::vector<double> LeafSides(std::span<const double> points) const = 0;

  // The features present, by id.
  virtual std::vector<Feature> Features() const = 0;

  // The options that the mesh was created with.
  virtual const MeshOptions& options() const = 0;
  // The number of batches applied; see ResumeAt.
  virtual std::uint64_t revision() const = 0;
  // The hash of the current mesh, O(1).
  virtual MeshHash hash() const = 0;
  // Counts and memory, O(1).
  virtual MeshStats Stats() const = 0;

  // Checks every invariant of trace and mesh, O(size). For tests and support. Returns the problems
  // found.
  virtual AuditReport Audit() const = 0;
};

// The mesher of BuildMesh.
enum class BuildEngine : std::uint8_t {
  // That of DynamicMesh, without a trace: the same mesh, built faster.
  kDynamic = 1,
  // Sparse Voronoi Refinement: another mesh with the same guarantees. It never has a mesh of bad
  // quality on the way, so its time is O(n lg(L/s) + m) for any input. Only for Delaunay meshes
  // with criterion kEdge, quality from sqrt(2), in 3D from 2, and min_dihedral 0; else
  // INVALID_ARGUMENT (BAD_OPTION).
  kSvr = 2,
};

// How a mesh is built. Nothing but `engine` and `only_inside` changes the resulting mesh.
struct BuildOptions {
  BuildEngine engine = BuildEngine::kDynamic;  // the mesher
  // 3D, kDynamic: the mesh is made for what its polygons enclose, and the rest is to be dropped. If
  // anything is enclosed, outside of it no sliver gets a Steiner point: `min_dihedral` holds inside
  // alone. All else holds outside, too. What is inside may have other Steiner points, as slivers on
  // its border are looked at from one side. Ignored in 2D, by kSvr and for quadtrees.
  bool only_inside = false;
  std::function<bool()> interrupted = nullptr;  // as in ApplyOptions: true gives up (CANCELLED)
  // As in ApplyOptions; of kSvr the most items of work, about one for each vertex.
  std::uint64_t max_operations = 0;
  std::function<void(const ApplyProgress&)> progress = nullptr;  // as in ApplyOptions
  // If it proves the features in a mesh of these options, they are not validated again. May be
  // null.
  std::shared_ptr<const ValidFeatures> valid = nullptr;
  // Called at most once, when `features` have been accepted and are not read any more: they may be
  // freed while the mesh is made, which may still fail. Not called for quadtrees.
  std::function<void()> features_read = nullptr;
};

// Builds a mesh without a trace. Its revision is 1 (0 if `features` is empty). A function of
// `features`, `options`, `build`.engine and `build`.only_inside; the order of features does not
// matter. It has the labels of the features. Errors: those of Create and Apply.
absl::StatusOr<Mesh> BuildMesh(std::span<const Feature> features, const MeshOptions& options,
                               const BuildOptions& build = {});

}  // namespace dynmesh

#endif  // DYNMESH_DYNAMIC_MESH_H_
