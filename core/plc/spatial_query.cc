// Queries of a SpatialIndex.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/plc/spatial_index.h"

namespace dynmesh::plc {
namespace {

// Covers the error of positions in units, and closed cells.
constexpr double kQueryReach = kCloseUnits + 1;

// What a query of a long feature has visited in cells with many features. Long ones side by side
// are together in many cells, and a pair of them takes much longer to judge than to leave out.
class Visited {
 public:
  // Calls visit(slot) for those that have not been visited in such a cell. `count`: of all slots.
  template <class Visit>
  static void ForEachNew(const std::vector<Slot>& slots, std::size_t count,
                         std::vector<bool>& visited, Visit visit) {
    constexpr std::size_t kMany = 32;
    const bool are_many = slots.size() > kMany;
    if (are_many && visited.size() < count) visited.resize(count);
    for (const Slot slot : slots) {
      if (are_many && visited[slot]) continue;
      if (are_many) visited[slot] = true;
      visit(slot);
    }
  }

  std::vector<bool> segments, facets;
};

}  // namespace

// A query defines which cells and children it enters, and which of their chords it visits.
template <int D>
template <typename Query>
void SpatialIndex<D>::Visit(NodeIndex n, const Cell& cell, const Query& query) const {
  if (!query.Enters(cell)) return;
  ++*query.cost;
  const Node& node = nodes_[n];
  if constexpr (D == 2) {
    if (node.chords != nullptr) query.VisitChords(*node.chords, cell);
  }
  *query.cost += node.points.size() + node.loose.size();
  for (const Slot slot : node.points) query.visit_point(points_[slot]);
  if constexpr (D == 2) {
    for (const Slot slot : node.loose) query.visit_segment(segments_[slot].feature);
  } else {
    *query.cost += node.facets.size();
    Visited& visited = query.visited;
    Visited::ForEachNew(node.loose, segments_.size(), visited.segments,
                        [&](Slot slot) { query.visit_segment(segments_[slot].feature); });
    Visited::ForEachNew(node.facets, facets_.size(), visited.facets,
                        [&](Slot slot) { query.visit_facet(*facets_[slot].facet); });
  }
  if (node.children == 0) return;
  query.ForChildrenNear(cell, [&](int i) { Visit(node.children + i, cell.Child(i), query); });
}

template <int D>
struct SpatialIndex<D>::PointQuery {
  UnitPoint<D> at;
  double reach;
  VisitPoint visit_point;
  VisitSegment visit_segment;
  VisitFacet visit_facet;
  std::uint64_t* cost;
  mutable Visited visited = {};

  bool Enters(const Cell& cell) const {
    for (int axis = 0; axis < D; ++axis) {
      if (at[axis] < cell.Lo(axis) - reach || at[axis] > cell.Hi(axis) + reach) {
        return false;
      }
    }
    return true;
  }

  template <class F>
  void ForChildrenNear(const Cell& cell, F f) const {
    cell.ForChildrenNear(at, at, reach, f);
  }

  // If the nearest point of a chord in this cell is at most r away, then at the cell's coordinate
  // nearest to `at` the chord passes at most 2 r from it: slopes are at most 1.
  void VisitChords(const ChordList& chords, const Cell& cell) const requires(D == 2) {
    for (int major = 0; major < 2; ++major) {
      const double along = std::clamp(at[major], cell.Lo(major), cell.Hi(major));
      const double across = at[1 - major];
      chords.Visit(major, {along, across, along, across}, 2 * reach,
                   [this](const GridSegment<2>& chord) {
                     ++*cost;
                     visit_segment(chord.feature);
                   });
    }
  }
};

template <int D>
struct SpatialIndex<D>::SegmentQuery {
  const GridSegment<D>* segment;
  // In units: what is nearer is visited. Cells are grown by `grown` to clip the segment, and chords
  // within `margin` of its part there are visited.
  double reach, grown, margin;
  VisitPoint visit_point;
  VisitSegment visit_segment;
  VisitFacet visit_facet;
  std::uint64_t* cost;
  mutable Visited visited = {};

  bool Enters(const Cell& cell) const { return segment->Meets(cell, reach); }
  template <class F>
  void ForChildrenNear(const Cell& cell, F f) const {
    segment->ForChildrenNear(cell, reach, f);
  }

  // The part of the segment in the grown cell, with an error well below a unit. False if there is
  // none: then another cell has all that the segment meets.
  bool Clip(const Cell& cell, UnitPoint<2>& a, UnitPoint<2>& b) const requires(D == 2) {
    const UnitPoint<2>&lo = segment->lo, &hi = segment->hi;
    double from = 0, to = 1;
    for (int axis = 0; axis < 2; ++axis) {
      const double d = hi[axis] - lo[axis];
      const double first = cell.Lo(axis) - grown - lo[axis],
                   last = cell.Hi(axis) + grown - lo[axis];
      if (d == 0) {
        if (first > 0 || last < 0) return false;
        continue;
      }
      from = std::max(from, (d > 0 ? first : last) / d);
      to = std::min(to, (d > 0 ? last : first) / d);
    }
    if (from > to) return false;
    for (int axis = 0; axis < 2; ++axis) {
      a[axis] = lo[axis] + (hi[axis] - lo[axis]) * from;
      b[axis] = lo[axis] + (hi[axis] - lo[axis]) * to;
    }
    return true;
  }

  // A chord that meets the part ab in the cell passes on different sides of a and b. Its positions
  // are taken in the cell's own range, at most `grown` from a and b. Slopes of chords are at most
  // 1: one that comes as near as r to ab is within 2 r of a or b, or between them.
  void VisitChords(const ChordList& chords, const Cell& cell) const requires(D == 2) {
    UnitPoint<2> a, b;
    if (!Clip(cell, a, b)) return;
    for (int major = 0; major < 2; ++major) {
      const double lo = cell.Lo(major), hi = cell.Hi(major);
      const ChordProbe positions = {std::clamp(a[major], lo, hi), a[1 - major],
                                    std::clamp(b[major], lo, hi), b[1 - major]};
      chords.Visit(major, positions, margin, [this](const GridSegment<2>& chord) {
        ++*cost;
        visit_segment(chord.feature);
      });
    }
  }
};

template <int D>
struct SpatialIndex<D>::FacetQuery {
  const GridFacet* facet;
  double reach;
  VisitPoint visit_point;
  VisitSegment visit_segment;
  VisitFacet visit_facet;
  std::uint64_t* cost;
  mutable Visited visited = {};

  bool Enters(const Cell& cell) const requires(D == 3) { return facet->Meets(cell, reach); }
  template <class F>
  void ForChildrenNear(const Cell& cell, F f) const requires(D == 3) {
    facet->ForChildrenNear(cell, reach, f);
  }
};

template <int D>
void SpatialIndex<D>::QueryNear(const geometry::Point<D>& p, VisitPoint visit_point,
                                VisitSegment visit_segment, VisitFacet visit_facet,
                                std::uint64_t* cost) const {
  Visit(0, grid_.root(),
        PointQuery{grid_.ToUnits(p), kQueryReach, visit_point, visit_segment, visit_facet, cost});
}

template <int D>
void SpatialIndex<D>::QueryNear(const SegmentFeature<D>& s, VisitPoint visit_point,
                                VisitSegment visit_segment, VisitFacet visit_facet,
                                std::uint64_t* cost) const {
  const GridSegment<D> segment(s, grid_);
  Visit(0, grid_.root(),
        SegmentQuery{&segment, kQueryReach, 1, 4, visit_point, visit_segment, visit_facet, cost});
}

template <int D>
void SpatialIndex<D>::QueryNear(const Facet& f, VisitPoint visit_point, VisitSegment visit_segment,
                                VisitFacet visit_facet, std::uint64_t* cost) const
    requires(D == 3) {
  const GridFacet facet(f, grid_);
  Visit(0, grid_.root(),
        FacetQuery{&facet, kQueryReach, visit_point, visit_segment, visit_facet, cost});
}

template <int D>
void SpatialIndex<D>::QueryNear(const geometry::Point<D>& p, VisitPoint visit_point,
                                VisitSegment visit_segment, std::uint64_t* cost) const {
  QueryNear(
      p, visit_point, visit_segment, [](const Facet&) {}, cost);
}

template <int D>
void SpatialIndex<D>::QueryNear(const SegmentFeature<D>& s, VisitPoint visit_point,
                                VisitSegment visit_segment, std::uint64_t* cost) const {
  QueryNear(
      s, visit_point, visit_segment, [](const Facet&) {}, cost);
}

template <int D>
void SpatialIndex<D>::QueryWithin(const SegmentFeature<D>& s, double distance,
                                  VisitSegment visit_segment, std::uint64_t* cost) const {
  QueryWithin(
      s, distance, [](const PointFeature<D>&) {}, visit_segment, cost);
}

template <int D>
void SpatialIndex<D>::QueryWithin(const SegmentFeature<D>& s, double distance,
                                  VisitPoint visit_point, VisitSegment visit_segment,
                                  std::uint64_t* cost) const {
  const auto ignore = [](const Facet&) {};
  const GridSegment<D> segment(s, grid_);
  const double reach = grid_.UnitsOf(distance) + 1;
  Visit(0, grid_.root(),
        SegmentQuery{&segment, reach, reach, 3 * reach + 4, visit_point, visit_segment, ignore,
                     cost});
}

template <int D>
void SpatialIndex<D>::QueryWithin(const geometry::Point<D>& p, double distance,
                                  VisitPoint visit_point, VisitSegment visit_segment,
                                  std::uint64_t* cost) const {
  const auto ignore = [](const Facet&) {};
  Visit(0, grid_.root(),
        PointQuery{grid_.ToUnits(p), grid_.UnitsOf(distance) + 1, visit_point, visit_segment,
                   ignore, cost});
}

template <int D>
void SpatialIndex<D>::QueryWithin(const Facet& f, double distance, VisitFacet visit_facet,
                                  std::uint64_t* cost) const requires(D == 3) {
  const auto ignore = [](const auto&) {};
  const GridFacet facet(f, grid_);
  Visit(0, grid_.root(),
        FacetQuery{&facet, grid_.UnitsOf(distance) + 1, ignore, ignore, visit_facet, cost});
}

using geometry::Point2;
using geometry::Point3;

template void SpatialIndex<2>::QueryNear(const Point2&, VisitPoint, VisitSegment,
                                         std::uint64_t*) const;
template void SpatialIndex<2>::QueryNear(const SegmentFeature<2>&, VisitPoint, VisitSegment,
                                         std::uint64_t*) const;
template void SpatialIndex<3>::QueryNear(const Point3&, VisitPoint, VisitSegment, VisitFacet,
                                         std::uint64_t*) const;
template void SpatialIndex<3>::QueryNear(const SegmentFeature<3>&, VisitPoint, VisitSegment,
                                         VisitFacet, std::uint64_t*) const;
template void SpatialIndex<3>::QueryNear(const Facet&, VisitPoint, VisitSegment, VisitFacet,
                                         std::uint64_t*) const;
template void SpatialIndex<2>::QueryWithin(const SegmentFeature<2>&, double, VisitSegment,
                                           std::uint64_t*) const;
template void SpatialIndex<2>::QueryWithin(const SegmentFeature<2>&, double, VisitPoint,
                                           VisitSegment, std::uint64_t*) const;
template void SpatialIndex<2>::QueryWithin(const Point2&, double, VisitPoint, VisitSegment,
                                           std::uint64_t*) const;
template void SpatialIndex<3>::QueryWithin(const SegmentFeature<3>&, double, VisitSegment,
                                           std::uint64_t*) const;
template void SpatialIndex<3>::QueryWithin(const Facet&, double, VisitFacet, std::uint64_t*) const;

}  // namespace dynmesh::plc
