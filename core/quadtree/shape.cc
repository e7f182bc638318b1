#include "core/quadtree/shape.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/geometry/predicates.h"

namespace dynmesh::quadtree {
namespace {

using geometry::Point;
using geometry::Point2;
using geometry::Point3;
using geometry::Ring3;

template <int D>
bool MeetAlongAxes(const Point<D>& p, const Point<D>& q, const Box<D>& box) {
  for (int k = 0; k < D; ++k) {
    if (std::max(p[k], q[k]) < box.lo[k] || std::min(p[k], q[k]) > box.hi[k]) return false;
  }
  return true;
}

// Is the box strictly on one side of line pq?
bool IsBeside(const Point2& p, const Point2& q, const Point2& lo, const Point2& hi) {
  if (p == q) return false;
  int sides = 0;
  for (const Point2& corner : {lo, Point2{{hi[0], lo[1]}}, hi, Point2{{lo[0], hi[1]}}}) {
    const int side = geometry::Orientation(p, q, corner);
    if (side == 0 || side == -sides) return false;
    sides = side;
  }
  return true;
}

Point2 Shadow(const Point3& p, int axis) { return {{p[(axis + 1) % 3], p[(axis + 2) % 3]}}; }

}  // namespace

// By separating axes: those of the box, and the segment's normals to them.
bool MeetsSegment(const Point2& p, const Point2& q, const Box<2>& box) {
  return MeetAlongAxes(p, q, box) && !IsBeside(p, q, box.lo, box.hi);
}
bool MeetsSegment(const Point3& p, const Point3& q, const Box<3>& box) {
  if (!MeetAlongAxes(p, q, box)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (IsBeside(Shadow(p, axis), Shadow(q, axis), Shadow(box.lo, axis), Shadow(box.hi, axis))) {
      return false;
    }
  }
  return true;
}

FacetShape::FacetShape(std::vector<Ring3> rings, std::vector<PointIndex> points)
    : rings_(std::move(rings)),
      points_(std::move(points)),
      plane_(geometry::PlaneOf(rings_)),
      interior_(rings_, plane_) {
  const geometry::FacetBounds bounds = geometry::BoundsOf(rings_, plane_);
  around_ = {bounds.lo, bounds.hi};
  std::sort(points_.begin(), points_.end());
  points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
}

bool FacetShape::Meets(const Box<3>& box) const {
  if (!around_.Meets(box)) return false;
  for (const Ring3& ring : rings_) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      if (MeetsSegment(ring[i], ring[(i + 1) % ring.size()], box)) return true;
    }
  }
  // No edge meets the box. So all that the box and the plane have in common is inside, or nothing
  // of it is. The lowest and the highest corner are the ends of a diagonal.
  Point3 low, high;
  for (int k = 0; k < 3; ++k) {
    const bool rises = plane_.normal[k] > 0;
    low[k] = rises ? box.lo[k] : box.hi[k];
    high[k] = rises ? box.hi[k] : box.lo[k];
  }
  const double below = plane_.Height(low), above = plane_.Height(high);
  if (below > 0 || above < 0) return false;
  const double part = above > below ? below / (below - above) : 0;
  Point3 p;
  for (int k = 0; k < 3; ++k) p[k] = low[k] + part * (high[k] - low[k]);
  return interior_.Holds(p);
}

}  // namespace dynmesh::quadtree
