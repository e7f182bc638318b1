// The net change of a 2D or 3D feature set, as plain data: the effect of a validated batch of
// edits. A value; no invariants except those below.
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

// A segment with its ends' ids, in the client's order, and positions. Also an edge of polygons: it
// has the id of the segment feature with the same ends (at most one), else of the polygon of least
// id with the end of lesser id first.
template <int D>
struct SegmentFeature {
  FeatureId id = kNoFeature;
  FeatureId p_id = kNoFeature;
  FeatureId q_id = kNoFeature;
  geometry::Point<D> p{};
  geometry::Point<D> q{};
  std::vector<FeatureId> polygons = {};  // with this edge, ascending
  bool is_marked = false;                // the segment feature itself is marked unsplit
  bool unsplit = false;                  // it is, or a polygon with this edge

  bool IsOfPolygon() const { return !polygons.empty() && polygons.front() == id; }
  friend bool operator==(const SegmentFeature&, const SegmentFeature&) = default;
};

// Two points, in any relation: the lesser id first.
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
  bool unsplit = false;
  friend bool operator==(const PolygonFeature&, const PolygonFeature&) = default;
};

// A 3D polygon for the mesher: a planar facet, its rings by id and by position. Its edges are
// segments as well.
struct FacetFeature {
  FeatureId id = kNoFeature;
  Rings rings;
  std::vector<std::vector<geometry::Point3>> positions;  // of the points of its rings
  friend bool operator==(const FacetFeature&, const FacetFeature&) = default;
};

// A sizing feature; `at` is its point, centre or lower corner.
template <int D>
struct SizeFeature {
  FeatureId id = kNoFeature;
  geometry::Point<D> at{};
  Sizing sizing;
  Rings rings = {};                                             // of a polygon
  std::vector<std::vector<geometry::Point<D>>> positions = {};  // of the points of its rings
  friend bool operator==(const SizeFeature&, const SizeFeature&) = default;
};

// Each list is sorted by id, segments of one id by their ends. No element is in both the removed
// and the added list of its kind. An id is in both if its feature changed (a moved point and its
// segments). If it changed kind, it is in the removed list of one kind and the added list of the
// other.
//
// In 3D a polygon is also a facet. The facet is added and removed with the polygon and its rings.
// It also changes if one of its corners moves, unlike the polygon. In 2D there are no facets.
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
  // Appends `next`, a change of what this adds. REQUIRES: this only adds. The result only adds,
  // too, and is sorted. O(n lg n).
  void Then(const Delta& next);
  // The change that undoes this one.
  Delta Inverse() const {
    return {added_points,  added_segments, removed_points,   removed_segments, added_sizes,
            removed_sizes, added_polygons, removed_polygons, added_facets,     removed_facets};
  }
  // The changes number `from` to `to` - 1. In this numbering each change is valid after those
  // before it: a feature is removed before, and added after, those that it depends on. O(to -
  // from). REQUIRES: from <= to <= size().
  Delta Part(std::size_t from, std::size_t to) const;
  friend bool operator==(const Delta&, const Delta&) = default;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_DELTA_H_
