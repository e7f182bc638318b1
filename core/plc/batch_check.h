// Validates one batch against the features present.
//
// Every problem has an edit to blame: the last edit that names a feature involved and changes it in
// the end. The ends of a segment are involved in each of its problems. So it is the edit at which
// entering the batch's *result* in this order would fail. The check does exactly this: it enters
// changed features one by one, in order of their edit, into a separate index, and checks each
// against the features that stay and those entered before. An edge of polygons is entered with the
// first of them, a facet after its edges and corners. The first problem found is the earliest,
// whatever the shape of the index.
//
// An edit that cannot act (draft.h) is the batch's error, unless the edits before it already have
// another problem that no later edit affects.
//
// At last it checks whether the result certainly needs more vertices than the mesh may have
// (batch_demand.cc, least_vertices.h): meshing would fail, too.
//
// Of a quadtree features may meet at any angle, and there are no sizing features.
//
// Expected time O(b lg b) for a batch that changes b features (including segments of a moved
// point), plus their queries of the index. One object, one run, one thread. Only reads the complex
// and its store.
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
  // All arguments must outlive the object and not change. `steps` are for the work before and after
  // the loop over changed features.
  BatchCheck(const MeshOptions& options, double limit, const CellGrid<D>& grid,
             const FeatureStore<D>& store, const FeatureIndex<D>& index, const Edits& batch,
             Steps& steps);

  absl::StatusOr<Delta<D>> Run(Interrupted interrupted);
  // The same for a batch that Run accepts, without a check.
  absl::StatusOr<Delta<D>> RunValid();
  // Index cells and features visited.
  std::uint64_t cost() const { return cost_; }

 private:
  // A check to do, in order of (edit, rank, id, kind, at).
  struct Event {
    enum class Kind : std::uint8_t {
      kPoint,       // a new or moved point: `at` in delta_.added_points
      kPointGone,   // users_of_missing_[id] need it
      kSegment,     // a new or changed segment: `at` in delta_.added_segments
      kDegenerate,  // both ends are the same point
      kUnknownEnd,
      kPolygon,  // its rings are no polygon, or the mesh allows none
      kEdge,     // a new or changed edge of a polygon: `at` in edges_
      kSize,     // a new or changed sizing feature: `at` in delta_.added_sizes
      kFacet,    // a new or changed facet: `at` in delta_.added_facets
    };
    EditIndex edit;
    FeatureId id;
    Kind kind;
    std::uint32_t at = 0;
    // Facets are checked after their edges.
    int rank() const {
      return kind == Kind::kPoint || kind == Kind::kPointGone ? 0 : kind == Kind::kFacet ? 2 : 1;
    }
  };

  // The conflict of a feature to report: the least conflict, with the least id.
  struct Obstacle {
    Conflict conflict = Conflict::kNone;
    AnyFeature<D> other;
  };

  // Collects all changes: delta_, events_, and the hidden features of the store.
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
  bool IsMarkedAfter(FeatureId polygon) const;
  EditIndex BlameOfMarks(std::span<const FeatureId> polygons) const;
  FeatureId SegmentAfter(const EdgeKey& key) const;
  // No Steiner points, so sizes, demand and small angles do not matter.
  bool splits_nothing() const { return options_.kind != MeshKind::kDelaunay; }
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
  // 2D. Is one unsplit, and the other in its way?
  template <typename F, typename G>
  bool Encroach(const F& f, const G& g);
  // 2D. Does the circle over unsplit segment `s` hold `p`, or is p on it and another point on its
  // other side?
  bool IsInCircle(const PointFeature<2>& p, const SegmentFeature<2>& s);
  absl::Status CheckDemand();
  absl::Status CheckSizeDemand() const;
  absl::Status CheckSegmentGaps();
  absl::Status CheckFacetGaps();
  Delta<D> TakeDelta();

  const MeshOptions& options_;
  const double limit_;
  const FeatureStore<D>& store_;
  Steps& steps_;
  const FeatureIndex<D>* present_;  // null if entered_ holds the features that stay, too
  const Draft<D> draft_;
  Delta<D> delta_;
  LargeVector<Event> events_;
  // Features of the store that are removed or changed in the result.
  absl::flat_hash_set<FeatureId> hidden_;
  absl::flat_hash_set<EdgeKey> hidden_edges_;
  absl::flat_hash_set<FeatureId> hidden_facets_;
  std::vector<FeatureId> affected_segments_, affected_sizes_, affected_polygons_, affected_facets_;
  std::vector<EdgeKey> affected_edges_;
  // Polygons of the store with removed or changed rings; edges of added polygons; segment
  // features that the batch names, by their ends.
  absl::flat_hash_set<FeatureId> changed_polygons_;
  absl::flat_hash_map<EdgeKey, std::vector<FeatureId>> new_users_;
  absl::flat_hash_map<EdgeKey, FeatureId> drafted_segments_;
  // `polygons` has only the polygon to blame. is_marked: by a segment feature that comes later.
  std::vector<SegmentFeature<D>> edges_;
  absl::flat_hash_map<FeatureId, std::vector<FeatureId>> users_of_missing_;
  FeatureIndex<D> entered_;
  std::uint64_t cost_ = 0;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_BATCH_CHECK_H_
