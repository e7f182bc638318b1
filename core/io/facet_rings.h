// Rings of corners in one plane of space, seen along an axis: which way round they go, and how
// they lie in each other. Exact: projecting a plane along an axis that it does not contain
// keeps both, and signs come from exact predicates. Of rings that are not in one plane it says
// something, too, but that is of no use.
//
// Pure functions, thread-safe. Coordinates as in core/geometry/predicates.h.
#ifndef DYNMESH_CORE_IO_FACET_RINGS_H_
#define DYNMESH_CORE_IO_FACET_RINGS_H_

#include <array>
#include <optional>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::io {

using PointRing = std::vector<geometry::Point3>;

// Can the predicates compute with it?
bool IsInDomain(const std::array<double, 3>& position);

// Two of the three coordinates.
struct AxisView {
  int first = 0;
  int second = 1;
  geometry::Point2 Of(const geometry::Point3& p) const { return {{p[first], p[second]}}; }
};

// The least corner of a ring in the view, between the corners before and behind it.
// REQUIRES: corners.
std::array<geometry::Point3, 3> LeastCorner(const PointRing& ring, AxisView view);

// 1 if the ring goes counter-clockwise in the view, -1 clockwise, 0 if its least corner is a
// spike or all are on one line: then it is no ring of a facet. O(corners).
int SignOf(const PointRing& ring, AxisView view);

// Twice the ring's area, along its normal: the sum of the corners' cross products. Rounded.
std::array<double, 3> AreaVector(const PointRing& ring);

// Along the axis in which the ring is largest, if its SignOf is not 0 there or along another
// axis. O(corners).
std::optional<AxisView> ViewOf(const PointRing& ring);

// Is the place in the ring, in the view? Places on the ring are on either side of it.
bool IsInside(const PointRing& ring, const geometry::Point3& place, AxisView view);

// For each ring, the number of others that it lies in. Rings may touch in corners, but not cross.
// None if a ring has all of its corners on another one. O(corners * rings).
std::optional<std::vector<int>> DepthsOf(const std::vector<PointRing>& rings, AxisView view);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FACET_RINGS_H_
