// The polygons of a 3D complex, as refinement sees them: their extents and the vertices on them.
//
// Like sizing regions they stand outside the time of the trace: there from the beginning or not at
// all. Whether a vertex is on a facet is decided by combinatorics, never by coordinates. On a facet
// are its corners, the vertices that split its edges, and those inserted for its sake.
// Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_FACET_FIELD_H_
#define DYNMESH_CORE_MESHING_FACET_FIELD_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "core/base/rings.h"
#include "core/base/rounding.h"
#include "core/geometry/facet_interior.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/box_tree.h"
#include "core/meshing/elements.h"
#include "core/meshing/spatial_tree.h"

namespace dynmesh::meshing {

using FacetIndex = std::uint32_t;

// The approximate extent of a facet.
struct FacetExtent {
  // May the ball meet the facet? Conservative: may return true needlessly, never false wrongly.
  bool MayMeet(const geometry::Point3& centre, double radius) const {
    for (int k = 0; k < 3; ++k) {
      if (!(box.lo[k] - radius <= centre[k] && centre[k] <= box.hi[k] + radius)) return false;
    }
    return std::fabs(plane.Height(centre)) <= radius + margin;
  }
  // May the facets have a distance of at most `distance`? Conservative: judges the boxes only.
  bool AreWithin(const FacetExtent& other, double distance) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!(box.lo[k] - distance <= other.box.hi[k] && other.box.lo[k] <= box.hi[k] + distance)) {
        return false;
      }
    }
    return true;
  }
  struct Ball {
    geometry::Point3 centre;
    double radius;
  };
  // Has all that is within `distance` of the box.
  Ball BallAround(double distance) const {
    Ball ball;
    double radius2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      ball.centre[k] = 0.5 * (box.lo[k] + box.hi[k]);
      const double half = 0.5 * (box.hi[k] - box.lo[k]) + distance;
      radius2 += half * half;
    }
    ball.radius = std::sqrt(radius2 * kBarelyWider);
    return ball;
  }
  // A lower bound of the distance from x to the facet.
  double LeastDistance(const geometry::Point3& x) const {
    double d2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = std::max({box.lo[k] - x[k], x[k] - box.hi[k], 0.0});
      d2 += d * d;
    }
    return std::max(std::sqrt(d2), std::fabs(plane.Height(x)) - margin);
  }

  Extent<3> box;
  geometry::FacetPlane plane;
  double margin = 0;  // more than any corner's distance from the plane
};

class Facet {
 public:
  using Point = geometry::Point3;
  using Edge = std::pair<VertexIndex, VertexIndex>;

  Facet() = default;
  // `position(v)`: the position of corner v.
  template <class Position>
  Facet(std::span<const std::vector<VertexIndex>> rings, FeatureSlot feature, Position position);

  FeatureSlot feature() const { return feature_; }
  const FacetExtent& where() const { return where_; }
  const geometry::FacetPlane& plane() const { return where_.plane; }
  const std::vector<geometry::Ring3>& rings() const { return rings_; }
  const std::vector<VertexIndex>& corners() const { return corners_; }
  bool HasCorner(VertexIndex v) const {
    return std::binary_search(corners_.begin(), corners_.end(), v);
  }
  // REQUIRES: v is a corner.
  const Point& PositionOf(VertexIndex v) const {
    const auto i = std::lower_bound(corners_.begin(), corners_.end(), v) - corners_.begin();
    return positions_[static_cast<std::size_t>(i)];
  }
  bool HasEdge(VertexIndex a, VertexIndex b) const {
    return std::binary_search(edges_.begin(), edges_.end(), Edge(a, b));
  }
  // The edges, each in both directions, sorted.
  std::span<const Edge> edges() const { return edges_; }
  // Those that begin at corner v.
  std::span<const Edge> EdgesAt(VertexIndex v) const {
    const auto first = std::lower_bound(edges_.begin(), edges_.end(), Edge(v, 0));
    const auto end = std::upper_bound(first, edges_.end(), Edge(v, kNil));
    return edges().subspan(static_cast<std::size_t>(first - edges_.begin()),
                           static_cast<std::size_t>(end - first));
  }
  // True if p is less than `height` away from the plane and its foot is inside the facet.
  bool IsOver(const Point& p, double height) const {
    return std::fabs(plane().Height(p)) < height && IsInside(plane().Foot(p));
  }
  // The distance from x to the facet. O(corners).
  double Distance(const Point& x) const;
  // An upper bound of the distance from a point of the facet to the nearest edge of the facet.
  double reach() const { return reach_; }
  // True if p, near the plane, is inside.
  bool IsInside(const Point& p) const { return interior_.Holds(p); }
  // True if `direction`, in the plane, leads from a corner at p into the inside.
  bool OpensTo(const Point& p, const geometry::Vector3& direction) const {
    return interior_.OpensTo(p, direction);
  }

 private:
  FeatureSlot feature_ = kNil;
  std::vector<geometry::Ring3> rings_;
  FacetExtent where_;
  geometry::FacetInterior interior_;
  double reach_ = 0;
  std::vector<VertexIndex> corners_;
  std::vector<Point> positions_;  // of the corners
  std::vector<Edge> edges_;
};

template <class Position>
Facet::Facet(std::span<const std::vector<VertexIndex>> rings, FeatureSlot feature,
             Position position)
    : feature_(feature) {
  for (const std::vector<VertexIndex>& ring : rings) {
    auto& positions = rings_.emplace_back();
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      positions.push_back(position(ring[i]));
      corners_.push_back(ring[i]);
      edges_.emplace_back(ring[i], ring[j]);
      edges_.emplace_back(ring[j], ring[i]);
    }
  }
  std::sort(corners_.begin(), corners_.end());
  std::sort(edges_.begin(), edges_.end());
  positions_.reserve(corners_.size());
  for (const VertexIndex v : corners_) positions_.push_back(position(v));
  const geometry::FacetPlane plane = geometry::PlaneOf(rings_);
  interior_ = geometry::FacetInterior(rings_, plane);
  const geometry::FacetBounds bounds = geometry::BoundsOf(rings_, plane);
  where_ = {{bounds.lo.c, bounds.hi.c}, plane, 2 * bounds.deviation};
  // A disc of radius r in the facet has an area of at most the facet's. Along axis k it extends by
  // r sqrt(1 - n_k^2), at most half of the box.
  double area = 0, widest = INFINITY;
  for (const geometry::Ring3& ring : rings_) {
    geometry::Vector3 sum = {0, 0, 0};
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
      const auto part = geometry::Cross(geometry::Difference(ring[i].c, ring[0].c),
                                        geometry::Difference(ring[i + 1].c, ring[0].c));
      for (std::size_t k = 0; k < 3; ++k) sum[k] += 0.5 * part[k];
    }
    area += std::sqrt(geometry::Dot(sum, sum));
  }
  for (int k = 0; k < 3; ++k) {
    if (k == plane.axis) continue;
    const double n = plane.normal[static_cast<std::size_t>(k)];
    widest = std::min(widest, 0.5 * (bounds.hi[k] - bounds.lo[k]) / std::sqrt(1 - n * n));
  }
  reach_ = kWider * std::min(std::sqrt(area / std::numbers::pi), widest);
}

inline double Facet::Distance(const Point& x) const {
  if (interior_.Holds(where_.plane.Foot(x))) return std::fabs(where_.plane.Height(x));
  double d2 = INFINITY;
  ForEachEdgeOf(rings_, [&](const Point& p, const Point& q) {
    d2 = std::min(d2, geometry::SquaredDistance(x, p, q));
  });
  return std::sqrt(d2);
}

class FacetField {
 public:
  using Point = geometry::Point3;

  FacetField(const Point& lo, const Point& hi) : extents_(lo, hi), reaches_(lo, hi) {}

  bool empty() const { return extents_.empty(); }
  std::size_t size() const { return of_feature_.size(); }
  const Facet& operator[](FacetIndex i) const { return facets_[i]; }

  FacetIndex Add(Facet facet);
  void Remove(FacetIndex index);

  // The facets that have input point v as a corner.
  std::span<const FacetIndex> AtCorner(VertexIndex v) const {
    const auto it = at_corner_.find(v);
    return it == at_corner_.end() ? std::span<const FacetIndex>() : it->second;
  }
  // True if that is an edge of a facet. O(facets at corner a).
  bool HasEdge(VertexIndex a, VertexIndex b) const {
    const auto facets = AtCorner(a);
    return std::any_of(facets.begin(), facets.end(),
                       [&](FacetIndex i) { return facets_[i].HasEdge(a, b); });
  }
  // The facet of that feature; kNil if there is none.
  FacetIndex OfFeature(FeatureSlot feature) const {
    const auto it = of_feature_.find(feature);
    return it == of_feature_.end() ? kNil : it->second;
  }
  // Calls f(facet) for the facets that the ball may meet.
  template <class F>
  void ForEachNear(const Point& centre, double radius, F f) const {
    ForEachNear(centre, radius, kNothingHidden, f);
  }
  // The same, but may skip facets in hidden boxes. is_hidden(centre, half of the sides): all in the
  // box is hidden.
  template <class IsHidden, class F>
  void ForEachNear(const Point& centre, double radius, IsHidden is_hidden, F f) const {
    AnyNear(centre, radius, is_hidden, [&](const Facet& facet) {
      f(facet);
      return false;
    });
  }
  // The same until accept(facet) is true; returns whether it was.
  template <class IsHidden, class Accept>
  bool AnyNear(const Point& centre, double radius, IsHidden is_hidden, Accept accept) const {
    return extents_.Any(centre, radius, INFINITY, is_hidden, [&](std::uint32_t i) {
      const Region& extent = extents_[i];
      if (!extent.where.MayMeet(centre, radius)) return false;
      Point middle;
      geometry::Vector3 half;
      for (int k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (extent.lo[k] + extent.hi[k]);
        half[k] = 0.5 * (extent.hi[k] - extent.lo[k]);
      }
      return !is_hidden(middle, half) && accept(facets_[extent.facet]);
    });
  }

  // Take something that lies in the box and is no nearer to any x than distance(x). These are the
  // facets that may be within their reach() of it.
  template <class Distance>
  std::vector<FacetIndex> Reaching(const Extent<3>& box, Distance distance) const {
    Point centre;
    double radius2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double half = 0.5 * (box.hi[k] - box.lo[k]);
      centre[k] = 0.5 * (box.lo[k] + box.hi[k]);
      radius2 += half * half;
    }
    const auto is_hidden = [&](const Point& middle, const geometry::Vector3& half) {
      return distance(middle) > std::sqrt(geometry::Dot(half, half));
    };
    std::vector<FacetIndex> reaching;
    reaches_.Any(centre, std::sqrt(radius2), INFINITY, is_hidden, [&](std::uint32_t i) {
      const Region& reach = reaches_[i];
      Point middle;
      geometry::Vector3 half;
      for (int k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (reach.lo[k] + reach.hi[k]);
        half[static_cast<std::size_t>(k)] = 0.5 * (reach.hi[k] - reach.lo[k]) + reach.radius;
      }
      if (!is_hidden(middle, half)) reaching.push_back(reach.facet);
      return false;
    });
    return reaching;
  }

  std::size_t bytes() const {
    return extents_.bytes() + reaches_.bytes() + facets_.capacity() * sizeof(Facet) +
           regions_of_.capacity() * sizeof(RegionsOf) + at_corner_.capacity() * 32 +
           of_feature_.capacity() * 9;
  }

 private:
  // The part of a facet that searches read first.
  struct Region {
    FacetIndex facet = 0;
    Point lo = {}, hi = {};
    double radius = 0;  // margin around the box
    FacetExtent where = {};
    static double LeastCell() { return 0; }
    static double Key() { return 0; }
  };
  struct RegionsOf {
    std::uint32_t extent, reach;
  };

  std::vector<Facet> facets_;
  std::vector<FacetIndex> free_;
  std::vector<RegionsOf> regions_of_;  // by facet
  BoxTree<3, Region> extents_;
  BoxTree<3, Region> reaches_;  // enlarged by reach(): the surroundings that may affect the
                                // facet's anchors
  absl::flat_hash_map<VertexIndex, absl::InlinedVector<FacetIndex, 4>> at_corner_;
  absl::flat_hash_map<FeatureSlot, FacetIndex> of_feature_;
};

inline FacetIndex FacetField::Add(Facet facet) {
  if (free_.empty()) {
    free_.push_back(static_cast<FacetIndex>(facets_.size()));
    facets_.emplace_back();
    regions_of_.emplace_back();
  }
  const FacetIndex index = free_.back();
  free_.pop_back();
  const Facet& added = facets_[index] = std::move(facet);
  for (const VertexIndex v : added.corners()) at_corner_[v].push_back(index);
  of_feature_[added.feature()] = index;
  const FacetExtent& where = added.where();
  Region region{index, {where.box.lo}, {where.box.hi}, 0, where};
  regions_of_[index].extent = extents_.Add(region);
  region.radius = added.reach();
  regions_of_[index].reach = reaches_.Add(region);
  return index;
}

inline void FacetField::Remove(FacetIndex index) {
  const Facet& facet = facets_[index];
  for (const VertexIndex v : facet.corners()) {
    const auto it = at_corner_.find(v);
    it->second.erase(std::find(it->second.begin(), it->second.end(), index));
    if (it->second.empty()) at_corner_.erase(it);
  }
  of_feature_.erase(facet.feature());
  extents_.Remove(regions_of_[index].extent);
  reaches_.Remove(regions_of_[index].reach);
  facets_[index] = {};
  free_.push_back(index);
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FACET_FIELD_H_
