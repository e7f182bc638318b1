// The net change of a feature set of the plane or of space, as plain data: what a validated
// batch of edits comes to. A value; no invariants beyond those below.
#ifndef DYNMESH_CORE_PLC_DELTA_H_
#define DYNMESH_CORE_PLC_DELTA_H_

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {

template <int D>
struct PointFeature {
  FeatureId id = kNoFeature;
  geometry::Point<D> p{};
  friend bool operator==(const PointFeature&, const PointFeature&) = default;
};

// A segment with the ids of its ends, in the client's order, and where they lie. An edge of
// polygons is one as well: with the id of the segment feature that joins the same points
// (there is one at most), else of the polygon of least id, the end of lesser id first.
template <int D>
struct SegmentFeature {
  FeatureId id = kNoFeature;
  FeatureId p_id = kNoFeature;
  FeatureId q_id = kNoFeature;
  geometry::Point<D> p{};
  geometry::Point<D> q{};
  std::vector<FeatureId> polygons = {};  // whose edge it is, ascending

  bool IsOfPolygon() const { return !polygons.empty() && polygons.front() == id; }
  friend bool operator==(const SegmentFeature&, const SegmentFeature&) = default;
};

// Two points, whatever joins them: the lesser id first.
using EdgeKey = std::pair<FeatureId, FeatureId>;
inline EdgeKey KeyOf(FeatureId p, FeatureId q) { return std::minmax(p, q); }
template <int D>
EdgeKey KeyOf(const SegmentFeature<D>& f) {
  return KeyOf(f.p_id, f.q_id);
}

// A polygon as the client gave it; its edges are segments (above).
struct PolygonFeature {
  FeatureId id = kNoFeature;
  Rings rings;
  friend bool operator==(const PolygonFeature&, const PolygonFeature&) = default;
};

// A polygon of space as the mesher sees it: a planar facet, its rings by id and by place. Its edges
// are segments as well.
struct FacetFeature {
  FeatureId id = kNoFeature;
  Rings rings;
  std::vector<std::vector<geometry::Point3>> places;  // of the points of its rings
  friend bool operator==(const FacetFeature&, const FacetFeature&) = default;
};

// A sizing feature: its point, centre or lower corner, and the rest.
template <int D>
struct SizeFeature {
  FeatureId id = kNoFeature;
  geometry::Point<D> at{};
  Sizing sizing;
  Rings rings = {};                                          // of a polygon
  std::vector<std::vector<geometry::Point<D>>> places = {};  // of the points of its rings
  friend bool operator==(const SizeFeature&, const SizeFeature&) = default;
};

// Each list is sorted by id, segments of one id by their ends. No element stands in both the
// removed and the added list of its kind; an id may, when its feature changed (a point that moved,
// and the segments that it took along). An id that changed kind stands in the removed list of one
// kind and the added list of the other.
//
// In space a polygon is a facet, too: a facet comes and goes with the polygon and its rings, and
// changes when one of its corners moves, which is no change of the polygon. In the plane there are
// no facets.
template <int D>
struct Delta {
  std::vector<PointFeature<D>> removed_points;
  std::vector<SegmentFeature<D>> removed_segments;
  std::vector<PointFeature<D>> added_points;
  std::vector<SegmentFeature<D>> added_segments;
  std::vector<SizeFeature<D>> removed_sizes;
  std::vector<SizeFeature<D>> added_sizes;
  std::vector<PolygonFeature> removed_polygons;
  std::vector<PolygonFeature> added_polygons;
  std::vector<FacetFeature> removed_facets;
  std::vector<FacetFeature> added_facets;

  std::size_t size() const {
    return removed_points.size() + removed_segments.size() + added_points.size() +
           added_segments.size() + removed_sizes.size() + added_sizes.size() +
           removed_polygons.size() + added_polygons.size() + removed_facets.size() +
           added_facets.size();
  }
  bool empty() const { return size() == 0; }
  void Sort();
  // Makes this, which only adds, the addition of what is there after `next`, a change of what it
  // adds. Sorts. O(n lg n).
  void Then(const Delta& next);
  // The change that undoes this one.
  Delta Inverse() const {
    return {added_points,  added_segments, removed_points,   removed_segments, added_sizes,
            removed_sizes, added_polygons, removed_polygons, added_facets,     removed_facets};
  }
  // The changes from the `from`-th to before the `to`-th, counted so that each can be made once
  // those before it are: what stands on something goes before it and comes after it.
  // O(to - from).
  // REQUIRES: from <= to <= size().
  Delta Part(std::size_t from, std::size_t to) const;
  friend bool operator==(const Delta&, const Delta&) = default;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_DELTA_H_
