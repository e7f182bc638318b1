// Extends SpatialIndex, in 2D, to any number of segments at a point. In 3D angles are too large for
// more than a few.
//
// At a *hub*, a point with many segments, all of these are near each other, so a spatial index
// cannot separate them. But a segment that ends there can conflict only with its neighbours in
// angle (those present make no small angles with each other). So segments added at a point with
// many segments are kept apart: in a separate index of that hub, for queries by all others, and in
// order of angle, for queries by segments that end there.
//
// Which segments belong to a hub depends on history. No verdict does: *answers* are supersets, as
// those of SpatialIndex. So filter by exact rules and choose by id.
//
// Cost: as SpatialIndex, plus O(1) per hub. For a segment at a hub of k segments, O(depth log k),
// independent of the number that a spatial index would visit there. Thread-compatible: const
// members may run concurrently.
#ifndef DYNMESH_CORE_PLC_FEATURE_INDEX_H_
#define DYNMESH_CORE_PLC_FEATURE_INDEX_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "absl/container/btree_set.h"
#include "absl/container/flat_hash_map.h"
#include "core/base/large_vector.h"
#include "core/geometry/angles.h"
#include "core/geometry/point.h"
#include "core/plc/spatial_index.h"

namespace dynmesh::plc {

template <int D>
class FeatureIndex;

template <>
class FeatureIndex<2> {
 public:
  using VisitPoint = SpatialIndex<2>::VisitPoint;
  using VisitSegment = SpatialIndex<2>::VisitSegment;

  // A point with this many segments is a hub for later ones. A lower value would make hubs of
  // ordinary points; a higher one would cost each segment there that many visits.
  static constexpr std::uint32_t kHubDegree = 64;

  explicit FeatureIndex(const CellGrid<2>& grid, std::uint32_t hub_degree = kHubDegree)
      : grid_(grid), hub_degree_(hub_degree), general_(grid) {}
  FeatureIndex(const FeatureIndex&) = delete;
  FeatureIndex& operator=(const FeatureIndex&) = delete;

  // Returns the slot for Erase; a slot may be reused after that.
  Slot Insert(const PointFeature<2>& point) { return general_.Insert(point); }
  Slot Insert(const SegmentFeature<2>& segment);
  void ErasePoint(Slot slot) { general_.ErasePoint(slot); }
  void EraseSegment(Slot slot);

  // Visits every feature less than 16 units (CloseLimit) away from `p`, and maybe others. Adds the
  // number of cells and features visited to *cost.
  void QueryNear(const geometry::Point2& p, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // Visits every point less than 16 units away from segment `s`; every segment that meets it
  // elsewhere than at a common end, or at too small an angle there; and maybe others.
  void QueryNear(const SegmentFeature<2>& s, VisitPoint visit_point, VisitSegment visit_segment,
                 std::uint64_t* cost) const;

  // Visits every segment less than `distance` away from segment `s` that has no end in common with
  // it, and maybe others.
  void QueryWithin(const SegmentFeature<2>& s, double distance, VisitSegment visit_segment,
                   std::uint64_t* cost) const;

  // Of unsplit segments: every one with a circle (the segment is its diameter) that holds `p`, or
  // meets segment `s`; and maybe others.
  void QueryCircles(const geometry::Point2& p, VisitSegment visit_segment,
                    std::uint64_t* cost) const;
  void QueryCircles(const SegmentFeature<2>& s, VisitSegment visit_segment,
                    std::uint64_t* cost) const;
  // Visits every point and segment that meets the circle over `s`, and maybe others. Of the
  // segments at an end of s it visits all that are as near, thousands at a hub.
  void QueryCircleOver(const SegmentFeature<2>& s, VisitPoint visit_point,
                       VisitSegment visit_segment, std::uint64_t* cost) const;

  std::size_t node_count() const;
  std::size_t bytes() const;  // about
  std::uint32_t hub_degree() const { return hub_degree_; }

 private:
  // A segment at a hub: its other end, and its slot in the hub's index.
  struct Spoke {
    geometry::Point2 end;
    Slot slot;
  };
  struct ByAngle {
    using is_transparent = void;
    geometry::Point2 apex;
    bool operator()(const Spoke& s, const Spoke& t) const {
      if (geometry::PrecedesInAngle(apex, s.end, t.end)) return true;
      return !geometry::PrecedesInAngle(apex, t.end, s.end) && s.slot < t.slot;
    }
    bool operator()(const Spoke& s, const geometry::Point2& end) const {
      return geometry::PrecedesInAngle(apex, s.end, end);
    }
    bool operator()(const geometry::Point2& end, const Spoke& s) const {
      return geometry::PrecedesInAngle(apex, end, s.end);
    }
  };
  struct Hub {
    Hub(const CellGrid<2>& grid, const geometry::Point2& at)
        : apex(at), lo(at), hi(at), segments(grid), by_angle(ByAngle{at}) {}
    geometry::Point2 apex;
    geometry::Point2 lo, hi;  // the box of all its segments so far
    SpatialIndex<2> segments;
    absl::btree_set<Spoke, ByAngle> by_angle;
  };
  // The location of a segment.
  struct Placement {
    FeatureId hub = kNoFeature;  // kNoFeature: in general_
    Slot slot = 0;               // there
    Slot circle = 0;             // unsplit: in unsplit_
  };

  // Unsplit segments of like length, and the greatest radius of their circles.
  static int LevelOf(const SegmentFeature<2>& segment);
  static double MostRadius(int level);

  void CountAt(const SegmentFeature<2>& segment, int change);
  FeatureId HubFor(const SegmentFeature<2>& segment) const;
  static void VisitNeighbours(const Hub& hub, const geometry::Point2& end,
                              VisitSegment visit_segment, std::uint64_t* cost);
  bool IsNear(const Hub& hub, const geometry::Point2& lo, const geometry::Point2& hi,
              double distance = 0) const;

  CellGrid<2> grid_;
  std::uint32_t hub_degree_;
  SpatialIndex<2> general_;
  absl::flat_hash_map<FeatureId, std::unique_ptr<Hub>> hubs_;
  absl::flat_hash_map<FeatureId, std::uint32_t> degrees_;  // of points with segments
  LargeVector<Placement> placements_;                      // by slot
  std::map<int, SpatialIndex<2>> unsplit_;                 // by level
  std::vector<Slot> free_;
};

template <>
class FeatureIndex<3> : public SpatialIndex<3> {
 public:
  static constexpr std::uint32_t kHubDegree = 0;

  explicit FeatureIndex(const CellGrid<3>& grid, std::uint32_t = kHubDegree)
      : SpatialIndex<3>(grid) {}
  std::uint32_t hub_degree() const { return kHubDegree; }
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FEATURE_INDEX_H_
