// Which features may be near a point or a segment? A quadtree or octree over the user's box.
//
// A point lies in one leaf. In the plane a segment is registered top down: as a *chord* of every
// highest cell that it meets and spans (chord_list.h), else in the children, else
// *loose* in a leaf. A leaf with more than kCapacity points and loose segments is
// split. So a long segment has O(1) chords per level near its ends and none in the
// small cells that it passes far from its ends, many long parallel segments cost a
// bisection. A cell of unit size meets one point or the segments of one end at most, since
// features are 16 units apart, and is not split (of ends of very many segments feature_index.h
// takes care).
//
// In space segments and facets are loose in every leaf that they meet. Chords have no order there,
// so one counts as a reason to split a leaf only where it is no more than 16 (a facet: 4) times as
// large as the leaf: for its own sake it is in few cells, and many large ones side by side cost
// their number where they are that near.
//
// Invariant: the segments present do not cross (ChordBefore needs it), so a feature
// is checked before it is inserted. The *answers* are supersets: every feature that
// conflicts with the query is among them, some others and duplicates may be; the tree's
// shape depends on history, hence filter by exact rules and pick by id.
//
// Cost: insert, erase and a point's query O(depth log n); a segment's query that for
// every leaf it meets. Depth is that of a quadtree of the feature's neighbourhood.
// Thread-compatible: const members may run at the same time.
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

  // The slot is what Erase takes; it may be reused after that.
  Slot Insert(const PointFeature<D>& point);
  Slot Insert(const SegmentFeature<D>& segment);
  Slot Insert(const Facet& facet) requires(D == 3);
  void ErasePoint(Slot slot);
  void EraseSegment(Slot slot);
  void EraseFacet(Slot slot) requires(D == 3);

  // Visits every feature less than 16 units (CloseLimit) away from `p`, and maybe
  // others. Adds the number of cells and features looked at to *cost.
  void QueryNear(const geometry::Point<D>& p, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // Visits every point less than 16 units away from segment `s`, every segment that
  // meets it (in space: that is less than 16 units away), and maybe others.
  void QueryNear(const SegmentFeature<D>& s, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // In space, facets as well: those that may be less than 16 units away, beyond what they are
  // thick; near facets also what lies beside them in their box.
  void QueryNear(const geometry::Point<D>& p, VisitPoint visit_point, VisitSegment visit_segment,
                 VisitFacet visit_facet, std::uint64_t* cost) const;
  void QueryNear(const SegmentFeature<D>& s, VisitPoint visit_point, VisitSegment visit_segment,
                 VisitFacet visit_facet, std::uint64_t* cost) const;
  void QueryNear(const Facet& f, VisitPoint visit_point, VisitSegment visit_segment,
                 VisitFacet visit_facet, std::uint64_t* cost) const requires(D == 3);

  // Visits every segment, in space every facet, that is less than `distance` away from `p`, and
  // maybe others; every facet that is less than `distance` away from f, and maybe others.
  void QueryWithin(const geometry::Point<D>& p, double distance, VisitSegment visit_segment,
                   std::uint64_t* cost) const;
  void QueryWithin(const Facet& f, double distance, VisitFacet visit_facet,
                   std::uint64_t* cost) const requires(D == 3);

  // A segment that has been inserted.
  const SegmentFeature<D>& segment(Slot slot) const { return segments_[slot].feature; }
  // Without what nodes list; about.
  std::size_t bytes() const {
    return nodes_.size() * sizeof(Node) + points_.size() * sizeof(points_[0]) +
           segments_.size() * sizeof(segments_[0]) + facets_.size() * sizeof(facets_[0]);
  }
  std::size_t node_count() const { return nodes_.size() - kChildren * free_blocks_.size(); }

 private:
  using NodeIndex = std::uint32_t;
  using Cell = plc::Cell<D>;
  static constexpr int kChildren = Cell::kChildren;
  static constexpr std::size_t kCapacity = 16;  // of a leaf: points and loose segments
  static constexpr std::size_t kMergeBelow = 8;

  struct PlaneNode {
    std::unique_ptr<ChordList> chords;  // maybe none
  };
  struct SpaceNode {
    std::vector<Slot> facets;  // ascending
  };
  struct Node : std::conditional_t<D == 2, PlaneNode, SpaceNode> {
    NodeIndex children = 0;  // the first of kChildren in a row; 0: a leaf
    std::vector<Slot> points;
    std::vector<Slot> loose;  // segments, ascending
  };
  struct PointQuery;
  struct SegmentQuery;
  struct FacetQuery;

  void InsertPointAt(NodeIndex n, const Cell& cell, Slot slot, const UnitPoint<D>& at);
  // Of segments and facets.
  template <typename Thing>
  const LargeVector<Thing>& TableOf() const;
  template <typename Thing>
  static std::vector<Slot>& ListOf(Node& node);
  template <typename Thing>
  void InsertThingAt(NodeIndex n, const Cell& cell, Slot slot);
  void ErasePointAt(NodeIndex n, const Cell& cell, Slot slot, const UnitPoint<D>& at);
  template <typename Thing>
  void EraseThingAt(NodeIndex n, const Cell& cell, Slot slot);
  std::size_t CrowdIn(const Node& node, const Cell& cell) const;
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
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_SPATIAL_INDEX_H_
