// Which features may be near a point or a segment? A quadtree over the user's box.
//
// A point lies in one leaf. A segment is registered top down: as a *chord* of every
// highest cell that it meets and spans (chord_list.h), else in the children, else
// *loose* in a leaf. A leaf with more than kCapacity points and loose segments is
// split. So a long segment has O(1) chords per level near its ends and none in the
// small cells that it passes far from its ends, many long parallel segments cost a
// bisection. A cell of unit size meets one point or the segments of one end at most, since
// features are 16 units apart, and is not split (of ends of very many segments feature_index.h
// takes care).
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
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/base/huge_pages.h"
#include "core/plc/cell_grid.h"
#include "core/plc/chord_list.h"
#include "core/plc/delta.h"

namespace dynmesh::plc {

class SpatialIndex {
 public:
  using VisitPoint = absl::FunctionRef<void(const PointFeature<2>&)>;
  using VisitSegment = absl::FunctionRef<void(const SegmentFeature<2>&)>;

  explicit SpatialIndex(const CellGrid& grid);
  SpatialIndex(const SpatialIndex&) = delete;
  SpatialIndex& operator=(const SpatialIndex&) = delete;

  // The slot is what Erase takes; it may be reused after that.
  Slot Insert(const PointFeature<2>& point);
  Slot Insert(const SegmentFeature<2>& segment);
  void ErasePoint(Slot slot);
  void EraseSegment(Slot slot);

  // Visits every feature less than 16 units (CloseLimit) away from `p`, and maybe
  // others. Adds the number of cells and features looked at to *cost.
  void QueryNear(const geometry::Point2& p, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // Visits every point less than 16 units away from segment `s`, every segment that
  // meets it, and maybe others.
  void QueryNear(const SegmentFeature<2>& s, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // A segment that has been inserted.
  const SegmentFeature<2>& segment(Slot slot) const { return segments_[slot].feature; }
  std::size_t node_count() const { return nodes_.size() - 4 * free_blocks_.size(); }

 private:
  using NodeIndex = std::uint32_t;
  static constexpr std::size_t kCapacity = 16;  // of a leaf: points and loose segments
  static constexpr std::size_t kMergeBelow = 8;

  struct Node {
    NodeIndex children = 0;  // the first of four in a row; 0: a leaf
    std::vector<Slot> points;
    std::vector<Slot> loose;            // ascending
    std::unique_ptr<ChordList> chords;  // maybe none
  };
  struct PointQuery;
  struct SegmentQuery;

  void InsertPointAt(NodeIndex n, const Cell& cell, Slot slot, const UnitPoint& at);
  void InsertSegmentAt(NodeIndex n, const Cell& cell, Slot slot);
  void ErasePointAt(NodeIndex n, const Cell& cell, Slot slot, const UnitPoint& at);
  void EraseSegmentAt(NodeIndex n, const Cell& cell, Slot slot);
  void SplitIfCrowded(NodeIndex n, const Cell& cell);
  void MergeIfSparse(NodeIndex n);
  NodeIndex AllocateChildren();
  template <typename Query>
  void Visit(NodeIndex n, const Cell& cell, const Query& query) const;

  static int QuadrantOf(const Cell& cell, const UnitPoint& at);

  CellGrid grid_;
  LargeVector<Node> nodes_;  // [0] is the root; children in blocks of four
  std::vector<NodeIndex> free_blocks_;
  LargeVector<PointFeature<2>> points_;
  std::vector<Slot> free_points_;
  SegmentTable segments_;
  std::vector<Slot> free_segments_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_SPATIAL_INDEX_H_
