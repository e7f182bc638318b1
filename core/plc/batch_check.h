// Validates one batch against the features present.
//
// Every problem has an edit to blame: the last one that names a feature involved and
// in the end changed; a segment's ends are involved in whatever it is. That is the edit
// at which one who enters the batch's *result* in this order would be stopped, so the
// check does just that: features that change are entered one by one, in order of their
// edit, into an index of their own, each checked against the features that stay and
// those entered before; an edge of polygons with the first of them, a facet when its edges and
// corners are in. The first problem met is the
// earliest, whatever the index's shape.
//
// A batch with an edit that cannot act (draft.h) is refused for it, unless the edits
// before it already are to blame for another problem that no later edit bears on.
//
// Expected time O(b lg b) for a batch that changes b features (segments that a moved
// point takes along included), plus their queries of the index.
// Last comes whether the result would take more vertices than the mesh may have, as far as that can
// be told at once (batch_demand.cc, least_vertices.h): what is refused here, meshing would refuse.
// One object, one run, one thread. The complex and its store are only read.
#ifndef DYNMESH_CORE_PLC_BATCH_CHECK_H_
#define DYNMESH_CORE_PLC_BATCH_CHECK_H_

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/large_vector.h"
#include "core/plc/delta.h"
#include "core/plc/draft.h"
#include "core/plc/edits.h"
#include "core/plc/feature_index.h"
#include "core/plc/feature_store.h"
#include "core/plc/messages.h"
#include "core/plc/rules.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

template <int D>
class BatchCheck {
 public:
  // All arguments must outlive the object and not change.
  // `steps` are those before and after the features that change are looked at one by one.
  BatchCheck(const MeshOptions& options, double limit, const CellGrid<D>& grid,
             const FeatureStore<D>& store, const FeatureIndex<D>& index, const Edits& batch,
             Steps& steps);

  absl::StatusOr<Delta<D>> Run(Interrupted interrupted);
  // Index cells and features looked at.
  std::uint64_t cost() const { return cost_; }

 private:
  // Something to look at, in order of (edit, rank, id, kind, at).
  struct Event {
    enum class Kind : std::uint8_t {
      kPoint,       // a point comes or moves: `at` in delta_.added_points
      kPointGone,   // users_of_missing_[id] need it
      kSegment,     // a segment comes or changes: `at` in delta_.added_segments
      kDegenerate,  // both ends the same point
      kUnknownEnd,
      kPolygon,  // its rings are no polygon, or the mesh can have none
      kEdge,     // of a polygon, comes or changes: `at` in edges_
      kSize,     // a sizing feature comes or changes: `at` in delta_.added_sizes
      kFacet,    // comes or changes: `at` in delta_.added_facets
    };
    EditIndex edit;
    FeatureId id;
    Kind kind;
    std::uint32_t at = 0;
    // Facets are looked at when their edges are in order.
    int rank() const {
      return kind == Kind::kPoint || kind == Kind::kPointGone ? 0 : kind == Kind::kFacet ? 2 : 1;
    }
  };

  // What stands in the way of a feature: the least conflict, of the least id.
  struct Obstacle {
    Conflict conflict = Conflict::kNone;
    AnyFeature<D> other;
  };

  // All that changes: delta_, events_, and what of the store is hidden.
  void Collect();
  void CollectPoint(const typename Draft<D>::Entry& entry);
  void CollectUsers(FeatureId point, bool is_point);
  void CollectSize(FeatureId id);
  void CollectPolygon(FeatureId id);
  void CollectFacet(FeatureId id);
  void FindAffectedEdges();
  void CollectSegment(FeatureId id);
  void CollectEdge(const EdgeKey& key);
  bool CheckPoints(FeatureId id, std::span<const FeatureId> points, EditIndex own);
  EditIndex BlameOfEdge(FeatureId feature, const EdgeKey& key) const;
  std::vector<FeatureId> PolygonsAfter(const EdgeKey& key) const;
  FeatureId SegmentAfter(const EdgeKey& key) const;
  bool knows_polygons() const { return !store_.polygons().empty() || draft_.has_polygons(); }
  bool IsHidden(const SegmentFeature<D>& f) const {
    return f.IsOfPolygon() ? hidden_edges_.contains(KeyOf(f)) : hidden_.contains(f.id);
  }
  bool IsCertainlyGood() const;
  void Schedule(const Event& event);
  void ChooseIndex();
  absl::Status Handle(const Event& event);
  template <typename F>
  absl::Status Enter(const F& feature, EditIndex edit);
  absl::Status UnknownEnd(FeatureId feature, EditIndex edit) const;
  template <typename F>
  Obstacle FindObstacle(const F& feature);
  absl::Status CheckDemand();
  absl::Status CheckRegions() const;
  absl::Status CheckSegmentGaps();
  absl::Status CheckFacetGaps();
  template <class Visit>
  void ForSegmentsWithin(const geometry::Point<D>& p, double distance, Visit visit);
  std::pair<double, SegmentFeature<D>> CrowdOn(const SegmentFeature<D>& s, double distance);
  bool IsAtSharpAngle(const SegmentFeature<D>& s);
  Delta<D> TakeDelta();

  const MeshOptions& options_;
  const double limit_;
  const FeatureStore<D>& store_;
  Steps& steps_;
  const FeatureIndex<D>* present_;  // null if entered_ holds the features that stay, too
  const Draft<D> draft_;
  Delta<D> delta_;
  LargeVector<Event> events_;
  // Features of the store that the result does not have as they are.
  absl::flat_hash_set<FeatureId> hidden_;
  absl::flat_hash_set<EdgeKey> hidden_edges_;
  absl::flat_hash_set<FeatureId> hidden_facets_;
  std::vector<FeatureId> affected_segments_, affected_sizes_, affected_polygons_, affected_facets_;
  std::vector<EdgeKey> affected_edges_;
  // Polygons of the store whose rings the result does not have; edges of those that come;
  // segment features that the batch names, by their ends.
  absl::flat_hash_set<FeatureId> changed_polygons_;
  absl::flat_hash_map<EdgeKey, std::vector<FeatureId>> new_users_;
  absl::flat_hash_map<EdgeKey, FeatureId> drafted_segments_;
  std::vector<SegmentFeature<D>> edges_;  // each with the polygon to blame, and that alone
  absl::flat_hash_map<FeatureId, std::vector<FeatureId>> users_of_missing_;
  FeatureIndex<D> entered_;
  std::uint64_t cost_ = 0;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_BATCH_CHECK_H_
