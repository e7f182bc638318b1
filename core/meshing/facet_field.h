// The polygons of a complex in space, as refinement sees them: where they are and who is on them.
//
// Like sizing features they stand outside the time of the trace: there from the beginning or not
// at all. Who is on a facet is a matter of combination, never of coordinates: its corners, what
// split its edges, what was put there for its sake. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_FACET_FIELD_H_
#define DYNMESH_CORE_MESHING_FACET_FIELD_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "core/geometry/facet_interior.h"
#include "core/geometry/facet_plane.h"
#include "core/meshing/elements.h"
#include "core/meshing/region_tree.h"
#include "core/meshing/spatial_tree.h"

namespace dynmesh::meshing {

using FacetIndex = std::uint32_t;

// Where a facet is, nearly.
struct FacetPlace {
  // May the ball hold a place of it? Never no if it does.
  bool MayMeet(const geometry::Point3& centre, double radius) const {
    for (int k = 0; k < 3; ++k) {
      if (!(box.lo[k] - radius <= centre[k] && centre[k] <= box.hi[k] + radius)) return false;
    }
    return std::fabs(plane.Height(centre)) <= radius + margin;
  }

  Extent<3> box;
  geometry::FacetPlane plane;
  double margin = 0;  // more than corners are off the plane
};

class Facet {
 public:
  using Point = geometry::Point3;
  using Edge = std::pair<VertexIndex, VertexIndex>;  // the lesser index first

  Facet() = default;
  // `position(v)`: of a corner.
  template <class Position>
  Facet(std::span<const std::vector<VertexIndex>> rings, FeatureSlot feature, Position position);

  FeatureSlot feature() const { return feature_; }
  FacetPlace where() const { return {{lo.c, hi.c}, plane_, margin_}; }
  const geometry::FacetPlane& plane() const { return plane_; }
  const std::vector<geometry::Ring3>& rings() const { return rings_; }
  const std::vector<VertexIndex>& corners() const { return corners_; }
  bool HasCorner(VertexIndex v) const {
    return std::binary_search(corners_.begin(), corners_.end(), v);
  }
  bool HasEdge(VertexIndex a, VertexIndex b) const {
    return std::binary_search(edges_.begin(), edges_.end(), Edge(std::minmax(a, b)));
  }
  // Is p, near the plane, inside?
  bool IsInside(const Point& p) const { return interior_.Holds(p); }

  // For RegionTree.
  Point lo = {}, hi = {};
  static constexpr double radius = 0;
  static double LeastCell() { return 0; }
  static double Key() { return 0; }

 private:
  FeatureSlot feature_ = kNil;
  std::vector<geometry::Ring3> rings_;
  geometry::FacetPlane plane_;
  geometry::FacetInterior interior_;
  double margin_ = 0;  // FacetPlace's
  std::vector<VertexIndex> corners_;
  std::vector<Edge> edges_;
};

template <class Position>
Facet::Facet(std::span<const std::vector<VertexIndex>> rings, FeatureSlot feature,
             Position position)
    : feature_(feature) {
  for (const std::vector<VertexIndex>& ring : rings) {
    auto& places = rings_.emplace_back();
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      places.push_back(position(ring[i]));
      corners_.push_back(ring[i]);
      edges_.push_back(std::minmax(ring[i], ring[j]));
    }
  }
  std::sort(corners_.begin(), corners_.end());
  std::sort(edges_.begin(), edges_.end());
  plane_ = geometry::PlaneOf(rings_);
  interior_ = geometry::FacetInterior(rings_, plane_);
  const geometry::FacetBounds bounds = geometry::BoundsOf(rings_, plane_);
  lo = bounds.lo;
  hi = bounds.hi;
  margin_ = 2 * bounds.deviation;
}

class FacetField {
 public:
  using Point = geometry::Point3;

  FacetField(const Point& lo, const Point& hi) : tree_(lo, hi) {}

  bool empty() const { return tree_.empty(); }
  const Facet& operator[](FacetIndex i) const { return tree_[i]; }

  FacetIndex Add(Facet facet);
  void Remove(FacetIndex index);

  // The facets with a corner at an input point.
  std::span<const FacetIndex> AtCorner(VertexIndex v) const {
    const auto it = at_corner_.find(v);
    return it == at_corner_.end() ? std::span<const FacetIndex>() : it->second;
  }
  // kNil if there is none of that feature.
  FacetIndex OfFeature(FeatureSlot feature) const {
    const auto it = of_feature_.find(feature);
    return it == of_feature_.end() ? kNil : it->second;
  }
  // Calls f(facet) for those that the ball may meet.
  template <class F>
  void ForEachNear(const Point& centre, double radius, F f) const {
    ForEachNear(centre, radius, kNothingHidden, f);
  }
  // The same, but for some that are hidden: is_hidden(
  // centre, half of the sides) says of a box that all in it is.
  template <class IsHidden, class F>
  void ForEachNear(const Point& centre, double radius, IsHidden is_hidden, F f) const {
    tree_.Any(centre, radius, INFINITY, is_hidden, [&](FacetIndex i) {
      const FacetPlace where = tree_[i].where();
      if (!where.MayMeet(centre, radius)) return false;
      Point middle;
      geometry::Vector3 half;
      for (int k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (where.box.lo[k] + where.box.hi[k]);
        half[k] = 0.5 * (where.box.hi[k] - where.box.lo[k]);
      }
      if (!is_hidden(middle, half)) f(tree_[i]);
      return false;
    });
  }

  std::size_t bytes() const {
    return tree_.bytes() + at_corner_.capacity() * 32 + of_feature_.capacity() * 9;
  }

 private:
  RegionTree<3, Facet> tree_;
  absl::flat_hash_map<VertexIndex, absl::InlinedVector<FacetIndex, 4>> at_corner_;
  absl::flat_hash_map<FeatureSlot, FacetIndex> of_feature_;
};

inline FacetIndex FacetField::Add(Facet facet) {
  const FacetIndex index = tree_.Add(std::move(facet));
  const Facet& added = tree_[index];
  for (const VertexIndex v : added.corners()) at_corner_[v].push_back(index);
  of_feature_[added.feature()] = index;
  return index;
}

inline void FacetField::Remove(FacetIndex index) {
  const Facet& facet = tree_[index];
  for (const VertexIndex v : facet.corners()) {
    const auto it = at_corner_.find(v);
    it->second.erase(std::find(it->second.begin(), it->second.end(), index));
    if (it->second.empty()) at_corner_.erase(it);
  }
  of_feature_.erase(facet.feature());
  tree_.Remove(index);
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FACET_FIELD_H_
