// Finds the features that may be near a point or a segment: a quadtree or octree over the user's
// box.
//
// A point is in one leaf. In 2D a segment is registered top down: as a *chord* of every highest
// cell that it meets and spans (chord_list.h), else in the children, else *loose* in a leaf. A leaf
// with more than kCapacity points and loose segments is split. So a long segment has O(1) chords
// per level near its ends, and none in the small cells far from its ends. Many long parallel
// segments cost a bisection. A cell of unit size meets at most one point or the segments of one
// end, since features are 16 units apart; it is not split (feature_index.h treats ends of very many
// segments).
//
// In 3D segments and facets are loose in every leaf that they meet. Chords have no order there. A
// segment counts towards splitting a leaf only if it is at most 16 (a facet: 4) times as large as
// the leaf. So a large feature is not in many cells for its own sake, and many large ones side by
// side cost their number where they are that close.
//
// Invariant: the segments present do not cross (ChordBefore needs it), so check a feature before
// inserting it. The *answers* are supersets: they contain every feature that conflicts with the
// query, and maybe others and duplicates. The tree's shape depends on history, so filter by exact
// rules and choose by id.
//
// Cost: insert, erase and a point's query O(depth log n); a segment's query that for every leaf it
// meets. Depth is that of a quadtree of the feature's neighbourhood. Thread-compatible: const
// members may run concurrently.
#ifndef DYNMESH_CORE_PLC_SPATIAL_INDEX_H_
#define DYNMESH_CORE_PLC_SPATIAL_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/base/large_vector.h"
#include "core/plc/cell_grid.h"
#include "core/plc/chord_list.h"
#include "core/plc/delta.h"
#include "core/plc/grid_facet.h"

namespace dynmesh::plc {

template <int D>
class SpatialIndex {
 public:
  using VisitPoint = absl::FunctionRef<void(const PointFeature<D>&)>;
  using VisitSegment = absl::FunctionRef<void(const SegmentFeature<D>&)>;
  using VisitFacet = absl::FunctionRef<void(const Facet&)>;

  explicit SpatialIndex(const CellGrid<D>& grid);
  SpatialIndex(const SpatialIndex&) = delete;
  SpatialIndex& operator=(const SpatialIndex&) = delete;

  // Returns the slot for Erase; a slot may be reused after that.
  Slot Insert(const PointFeature<D>& point);
  Slot Insert(const SegmentFeature<D>& segment);
  Slot Insert(const Facet& facet) requires(D == 3);
  void ErasePoint(Slot slot);
  void EraseSegment(Slot slot);
  void EraseFacet(Slot slot) requires(D == 3);

  // Visits every feature less than 16 units (CloseLimit) away from `p`, and maybe others. Adds the
  // number of cells and features visited to *cost.
  void QueryNear(const geometry::Point<D>& p, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // Visits every point less than 16 units away from segment `s`, every segment that meets it (3D:
  // that is less than 16 units away), and maybe others.
  void QueryNear(const SegmentFeature<D>& s, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // 3D: also visits facets that may be less than 16 units away, beyond their thickness. The query
  // of a facet also visits features beside it in its box.
  void QueryNear(const geometry::Point<D>& p, VisitPoint visit_point, VisitSegment visit_segment,
                 VisitFacet visit_facet, std::uint64_t* cost) const;
  void QueryNear(const SegmentFeature<D>& s, VisitPoint visit_point, VisitSegment visit_segment,
                 VisitFacet visit_facet, std::uint64_t* cost) const;
  void QueryNear(const Facet& f, VisitPoint visit_point, VisitSegment visit_segment,
                 VisitFacet visit_facet, std::uint64_t* cost) const requires(D == 3);

  // Visits every segment less than `distance` away from s, and maybe others; every facet less than
  // `distance` away from f, and maybe others.
  void QueryWithin(const SegmentFeature<D>& s, double distance, VisitSegment visit_segment,
                   std::uint64_t* cost) const;
  // Visits every point and segment less than `distance` away from s, or from p, and maybe others.
  void QueryWithin(const SegmentFeature<D>& s, double distance, VisitPoint visit_point,
                   VisitSegment visit_segment, std::uint64_t* cost) const;
  void QueryWithin(const geometry::Point<D>& p, double distance, VisitPoint visit_point,
                   VisitSegment visit_segment, std::uint64_t* cost) const;
  void QueryWithin(const Facet& f, double distance, VisitFacet visit_facet,
                   std::uint64_t* cost) const requires(D == 3);

  // A segment that was inserted.
  const SegmentFeature<D>& segment(Slot slot) const { return segments_[slot].feature; }
  // Approximate; without the lists of nodes.
  std::size_t bytes() const {
    return nodes_.size() * sizeof(Node) + points_.size() * sizeof(points_[0]) +
           segments_.size() * sizeof(segments_[0]) + facets_.size() * sizeof(facets_[0]);
  }
  std::size_t node_count() const { return nodes_.size() - kChildren * free_blocks_.size(); }
  // How many features of leaves were looked at so far, to find out which leaves are crowded.
  std::uint64_t looked_at() const { return looked_at_; }

 private:
  using NodeIndex = std::uint32_t;
  using Cell = plc::Cell<D>;
  static constexpr int kChildren = Cell::kChildren;
  static constexpr std::size_t kCapacity = 16;  // of a leaf: points and loose segments
  static constexpr std::size_t kMergeBelow = 8;

  struct PlaneNode {
    std::unique_ptr<ChordList> chords;  // may be null
  };
  struct SpaceNode {
    std::vector<Slot> facets;  // ascending
  };
  struct Node : std::conditional_t<D == 2, PlaneNode, SpaceNode> {
    NodeIndex children = 0;  // the first of kChildren consecutive ones; 0: a leaf
    std::vector<Slot> points;
    std::vector<Slot> loose;  // segments, ascending
  };
  struct PointQuery;
  struct SegmentQuery;
  struct FacetQuery;

  void InsertPointAt(NodeIndex n, const Cell& cell, Slot slot, const UnitPoint<D>& at);
  // For segments and facets.
  template <typename Thing>
  const LargeVector<Thing>& TableOf() const;
  template <typename Thing>
  static std::vector<Slot>& ListOf(Node& node);
  template <typename Thing>
  void InsertThingAt(NodeIndex n, const Cell& cell, Slot slot);
  void ErasePointAt(NodeIndex n, const Cell& cell, Slot slot, const UnitPoint<D>& at);
  template <typename Thing>
  void EraseThingAt(NodeIndex n, const Cell& cell, Slot slot);
  // Does the feature count towards splitting a leaf of that cell?
  template <typename Thing>
  static bool Crowds(const Thing& thing, const Cell& cell);
  std::size_t CrowdIn(const Node& node, const Cell& cell);
  void SplitIfCrowded(NodeIndex n, const Cell& cell);
  void MergeIfSparse(NodeIndex n, const Cell& cell);
  NodeIndex AllocateChildren();
  template <typename Query>
  void Visit(NodeIndex n, const Cell& cell, const Query& query) const;

  static int ChildAt(const Cell& cell, const UnitPoint<D>& at);

  CellGrid<D> grid_;
  LargeVector<Node> nodes_;  // [0] is the root; children in blocks
  std::vector<NodeIndex> free_blocks_;
  LargeVector<PointFeature<D>> points_;
  std::vector<Slot> free_points_;
  SegmentTable<D> segments_;
  std::vector<Slot> free_segments_;
  LargeVector<GridFacet> facets_;
  std::vector<Slot> free_facets_;
  std::uint64_t looked_at_ = 0;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_SPATIAL_INDEX_H_
