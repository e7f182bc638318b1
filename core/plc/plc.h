// The piecewise linear complex: the features of a 2D or 3D mesh, by id and without labels
// (labels.h), and the rules of legal input.
//
// Invariants, after every Apply of a Delta that Check returned:
//   0. sizing features are legal by themselves (messages.h, CheckSize);
//   1. every point is finite, in the user's closed box, its coordinates 0 or of magnitude at least
//      2^-200, never -0;
//   2. every segment joins two different points present; rings of polygons are of points present
//      and legal by messages.h, CheckRings;
//   3. no two features are too close, cross, overlap or coincide; no point is in the inside of a
//      segment; no two segments with a common end are nearly equal (rules.h). Edges of polygons are
//      segments here, once if several join the same points; A quadtree allows any angle, here and
//      in 4;
//   4. 3D: polygons are facets, and flat (messages.h, CheckFacet). With each other, with points and
//      with segments they have only corners and edges in common. No feature is too close to their
//      insides, and angles are 1 degree or more (facet_rules.h). A mesh with a quality below 1.4
//      has none (options.h).
// The acceptance of a batch, its Delta and its error are functions of the feature set and the
// batch, never of history.
//
// Thread-compatible: Apply excludes all other calls; const members may run concurrently.
#ifndef DYNMESH_CORE_PLC_PLC_H_
#define DYNMESH_CORE_PLC_PLC_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/steps.h"
#include "core/plc/delta.h"
#include "core/plc/edits.h"
#include "core/plc/feature_index.h"
#include "core/plc/feature_store.h"
#include "core/plc/rules.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

template <int D>
class Plc {
 public:
  // REQUIRES: ValidateOptions(options) is OK.
  // `hub_degree` affects how features are kept (feature_index.h), not the answers.
  explicit Plc(const MeshOptions& options, std::uint32_t hub_degree = FeatureIndex<D>::kHubDegree);
  Plc(const Plc&) = delete;
  Plc& operator=(const Plc&) = delete;

  // Applies the batch to a draft, validates the result, returns the net change. Changes nothing. If
  // the result is illegal: the error of the earliest edit to blame, with ErrorDetail (error.h).
  // batch_check.h defines that edit.
  //   INVALID_ARGUMENT     BAD_ID, WRONG_KIND, NOT_FINITE, OUTSIDE_BOX, DEGENERATE_SEGMENT,
  //                        TOO_CLOSE (a coordinate to 0), BAD_SIZE, BAD_POLYGON, BAD_LABEL
  //   NOT_FOUND            UNKNOWN_FEATURE
  //   ALREADY_EXISTS       ID_IN_USE
  //   FAILED_PRECONDITION  UNKNOWN_END, POINT_IN_USE, DUPLICATE_POINT, DUPLICATE_SEGMENT,
  //                        POINT_ON_SEGMENT, SEGMENTS_CROSS, SEGMENTS_OVERLAP,
  //                        SMALL_INPUT_ANGLE, TOO_CLOSE; of 3D polygons
  //                        NON_PLANAR, DUPLICATE_POLYGON, POINT_ON_POLYGON,
  //                        SEGMENT_MEETS_POLYGON, POLYGONS_MEET, QUALITY_TOO_LOW
  //   RESOURCE_EXHAUSTED   VERTEX_LIMIT, if the features certainly need more vertices than the mesh
  //                        may have (least_vertices.h)
  // Cost: that of the batch and its neighbourhood (batch_check.h, feature_index.h). If `cost` is
  // not null, adds the number of index cells and features visited to it. Large batches of long
  // segments take minutes, so it polls `interrupted`: for each changed feature, with the number
  // still to check; and before these are counted, once every Steps::kBetween features. Once
  // `interrupted` returns true, the result is CANCELLED (reason CANCELLED).
  absl::StatusOr<Delta<D>> Check(
      const Edits& batch, std::uint64_t* cost = nullptr,
      Interrupted interrupted = [](std::size_t) { return false; }) const;
  absl::StatusOr<Delta<D>> Check(
      const EditBatch& batch, std::uint64_t* cost = nullptr,
      Interrupted interrupted = [](std::size_t) { return false; }) const {
    return Check(Edits(batch), cost, interrupted);
  }

  // What Check returns of a batch that it accepts, without validating it. REQUIRES: Check accepts
  // it. CANCELLED once `interrupted` returns true. O(b lg b) for b features that change.
  absl::StatusOr<Delta<D>> ChangeOfValid(const Edits& batch, Interrupted interrupted) const;

  // Applies a change. REQUIRES: `delta` is Check's for the features present, or the inverse of the
  // last one. O(delta) insertions and removals in the index, amortised: once three of four features
  // are removed, all structures are rebuilt to free memory.
  void Apply(const Delta<D>& delta);

  // All features, sorted by id; unused members are 0. O(n lg n).
  std::vector<Feature> Features() const;

  // The change from no features to all present. O(n lg n). If `steps` stop, the result is
  // unspecified.
  Delta<D> FromNothing(Steps& steps) const;
  Delta<D> FromNothing() const {
    AllSteps all;
    return FromNothing(all);
  }

  std::size_t size() const { return store_.size(); }
  // Approximate memory of what is kept per feature.
  std::size_t bytes() const { return store_.bytes() + index_->bytes(); }

  // For tests: what is kept.
  const FeatureStore<D>& store() const { return store_; }
  const FeatureIndex<D>& index() const { return *index_; }

 private:
  void Insert(const Delta<D>& delta);
  void GiveMemoryBack();

  const MeshOptions options_;
  const double limit_;
  const CellGrid<D> grid_;
  FeatureStore<D> store_;
  std::unique_ptr<FeatureIndex<D>> index_;
  std::size_t most_ = 0;  // most features since memory was freed
};

using Plc2 = Plc<2>;
using Plc3 = Plc<3>;

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_PLC_H_
