// Orientation and nesting of rings of corners in one plane, in a view along an axis. Exact:
// projection along an axis that the plane does not contain preserves both, and signs come from
// exact predicates. For rings that are not coplanar the results are meaningless.
//
// Pure functions, thread-safe. Coordinates as in core/geometry/predicates.h.
#ifndef DYNMESH_CORE_COPLANAR_FACET_RINGS_H_
#define DYNMESH_CORE_COPLANAR_FACET_RINGS_H_

#include <array>
#include <optional>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::coplanar {

using PointRing = std::vector<geometry::Point3>;

// Are its coordinates valid for the predicates?
bool IsInDomain(const std::array<double, 3>& position);

// The view along an axis: two of the three coordinates.
struct AxisView {
  int first = 0;
  int second = 1;
  geometry::Point2 Of(const geometry::Point3& p) const { return {{p[first], p[second]}}; }
};

// The least corner of a ring in the view, between the corners before and after it. REQUIRES: the
// ring is not empty.
std::array<geometry::Point3, 3> LeastCorner(const PointRing& ring, AxisView view);

// 1 if the ring is counter-clockwise in the view, -1 if clockwise. 0 if its least corner is a spike
// or all corners are collinear: then it is no ring of a facet. O(corners).
int SignOf(const PointRing& ring, AxisView view);

// Twice the ring's area, along its normal: the sum of the corners' cross products. Rounded.
std::array<double, 3> AreaVector(const PointRing& ring);

// The axis along which the ring is largest if its SignOf is not 0 there, else another axis with
// SignOf not 0. O(corners).
std::optional<AxisView> ViewOf(const PointRing& ring);

// Is the position inside the ring, in the view? On the ring the result may be either.
bool IsInside(const PointRing& ring, const geometry::Point3& position, AxisView view);

// For each ring, the number of others around it. Rings may touch in corners, but must not cross.
// None if all corners of a ring are on another one. O(corners * rings).
std::optional<std::vector<int>> DepthsOf(const std::vector<PointRing>& rings, AxisView view);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_FACET_RINGS_H_
