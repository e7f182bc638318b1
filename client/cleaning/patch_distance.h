// Is a triangle near a set of triangles? A bound for all its points, not for samples.
//
// The distance to one triangle is a convex function. So a convex piece is within D of the set if
// all its corners are within D of one and the same triangle of it. Else it is cut: where the prism
// over that triangle ends, or in the middle, and both parts are looked at.
//
// Decisions are rigorous up to rounding, some 1e-15 of the coordinates. They are functions of the
// order of corners and targets. Pure, thread-safe.
#ifndef DYNMESH_CLIENT_CLEANING_PATCH_DISTANCE_H_
#define DYNMESH_CLIENT_CLEANING_PATCH_DISTANCE_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "client/cleaning/box3.h"
#include "client/cleaning/node_table.h"

namespace dynmesh::cleaning {

using TriangleCorners = std::array<Point3, 3>;

// The point of the triangle that is nearest to p (C. Ericson, Real-Time Collision Detection, 2005,
// 5.1.5).
Point3 NearestOn(const TriangleCorners& triangle, const Point3& p);

// A triangle that others are compared with.
struct DistanceTarget {
  explicit DistanceTarget(const TriangleCorners& triangle);

  TriangleCorners corners;
  Box3 box;
  std::array<Point3, 3> inwards{};  // of edge i: in the triangle's plane, of length 1
};

// Is each point of `triangle` within `distance` of some target? "No" may be wrong if that takes
// more than some cuts for each target. If "yes", appends the targets that the proof needs to
// `used`, some more than once. Expected O(n) for each piece and n targets, but little more than
// looking at their boxes.
bool IsWithin(const TriangleCorners& triangle, std::span<const DistanceTarget> targets,
              double distance, std::vector<std::uint32_t>& used);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_PATCH_DISTANCE_H_
