// What a feature is to a quadtree: which closed boxes it meets, and which input points it has.
//
// Two features have nothing in common iff they have no input point in common: the rules of legal
// input (plc.h) exclude all else. Immutable, thread-safe.
#ifndef DYNMESH_CORE_QUADTREE_SHAPE_H_
#define DYNMESH_CORE_QUADTREE_SHAPE_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/geometry/facet_interior.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"
#include "core/quadtree/cell.h"

namespace dynmesh::quadtree {

// An input point, as an index.
using PointIndex = std::uint32_t;
// A feature, as an index into a table of shapes.
using ShapeIndex = std::uint32_t;

// Do segment pq and the box have a point in common? Exact: if it meets a box, it meets each box
// around that one. p = q is a point. O(1).
bool MeetsSegment(const geometry::Point2& p, const geometry::Point2& q, const Box<2>& box);
bool MeetsSegment(const geometry::Point3& p, const geometry::Point3& q, const Box<3>& box);

// A planar polygon in 3D, with holes or not.
class FacetShape {
 public:
  // `points`: of the rings.
  FacetShape(std::vector<geometry::Ring3> rings, std::vector<PointIndex> points);

  // Sorted, each once.
  std::span<const PointIndex> points() const { return points_; }

  // Where only its inside meets the box, rounding decides at the box's corners. O(corners).
  bool Meets(const Box<3>& box) const;

 private:
  std::vector<geometry::Ring3> rings_;
  std::vector<PointIndex> points_;
  geometry::FacetPlane plane_;
  geometry::FacetInterior interior_;
  Box<3> around_;
};

template <int D>
class Shape {
 public:
  using Point = geometry::Point<D>;

  static Shape OfPoint(const Point& p, PointIndex index) { return {p, p, index, index}; }
  static Shape OfSegment(const Point& p, const Point& q, PointIndex p_index, PointIndex q_index) {
    return {p, q, p_index, q_index};
  }
  static Shape OfFacet(std::shared_ptr<const FacetShape> facet) requires(D == 3) {
    Shape shape({}, {}, 0, 0);
    shape.facet_ = std::move(facet);
    return shape;
  }

  // Sorted, each once.
  std::span<const PointIndex> points() const {
    if constexpr (D == 3) {
      if (facet_ != nullptr) return facet_->points();
    }
    return {ends_.data(), ends_[0] == ends_[1] ? 1u : 2u};
  }
  bool Meets(const Box<D>& box) const {
    if constexpr (D == 3) {
      if (facet_ != nullptr) return facet_->Meets(box);
    }
    if (ends_[0] == ends_[1]) return box.Holds(p_);
    if constexpr (D <= 3) return MeetsSegment(p_, q_, box);
    return false;  // there are only points
  }
  // Bit i: Meets(child i). REQUIRES: it meets the cell.
  std::uint32_t ChildrenMet(const Halves<D>& cell) const {
    if constexpr (D == 3) {
      if (facet_ != nullptr) return ThoseMet((1u << Cell<D>::kChildren) - 1, cell);
    }
    if (ends_[0] == ends_[1]) return cell.ChildrenMet(p_, p_);
    const Box<D> around = Around();
    const std::uint32_t candidates = cell.ChildrenMet(around.lo, around.hi);
    // It meets one of them, as it meets the cell.
    return std::has_single_bit(candidates) ? candidates : ThoseMet(candidates, cell);
  }
  // True if it meets the box. May be true of a short segment that passes by: this is faster.
  bool MayMeet(const Box<D>& box) const {
    if constexpr (D == 3) {
      if (facet_ != nullptr) return facet_->Meets(box);
    }
    const Box<D> around = Around();
    if (!around.Meets(box)) return false;
    for (int k = 0; k < D; ++k) {
      if (around.hi[k] - around.lo[k] > box.hi[k] - box.lo[k]) return Meets(box);
    }
    return true;
  }

 private:
  Shape(const Point& p, const Point& q, PointIndex p_index, PointIndex q_index)
      : p_(p), q_(q), ends_{std::min(p_index, q_index), std::max(p_index, q_index)} {}

  std::uint32_t ThoseMet(std::uint32_t candidates, const Halves<D>& cell) const {
    std::uint32_t met = 0;
    for (std::uint32_t left = candidates; left != 0; left &= left - 1) {
      const int which = std::countr_zero(left);
      if (Meets(cell.Child(which))) met |= 1u << which;
    }
    return met;
  }
  // REQUIRES: no facet.
  Box<D> Around() const {
    Box<D> around;
    for (int k = 0; k < D; ++k) {
      around.lo[k] = std::min(p_[k], q_[k]);
      around.hi[k] = std::max(p_[k], q_[k]);
    }
    return around;
  }

  struct Nothing {};
  Point p_, q_;
  std::array<PointIndex, 2> ends_;
  [[no_unique_address]] std::conditional_t<D == 3, std::shared_ptr<const FacetShape>, Nothing>
      facet_;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_SHAPE_H_
