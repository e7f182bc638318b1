// Walls that come or go: what one has to cross to get from one region into another. In the plane
// an edge of polygons, in space a polygon that is part of a closed surface.
//
// What the walls that changed change at a place is told by a ray from there: all those that it
// crosses an odd number of times. Shadows along the ray are decided by exact predicates. A place
// in line with an end or an edge of a wall counts as moved aside by an infinitesimal amount, which
// is the same for all walls: so a ray passes between two walls that join, or crosses both or one
// of them, as it would if it passed at a little distance. Pure functions, thread-safe.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_WALL_H_
#define DYNMESH_CORE_DYNAMIC_MESH_WALL_H_

#include <optional>
#include <vector>

#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"
#include "dynmesh/feature.h"

namespace dynmesh {

template <int D>
struct Wall;

template <>
struct Wall<2> {
  geometry::Point2 p, q;
  std::vector<FeatureId> owners;  // polygons with an edge there, ascending
};

// Planar up to its thickness: corners are off the plane by less.
template <>
struct Wall<3> {
  Wall(std::vector<geometry::Ring3> rings, std::vector<FeatureId> owners);

  std::vector<geometry::Ring3> rings;
  std::vector<FeatureId> owners;  // closed surfaces that it was or is part of, ascending
  geometry::FacetPlane plane;
  double thickness;
  geometry::Point3 lo, hi;
};

// Rays to choose from: which one is taken makes no difference to what is told, but some cannot
// tell. In space, along an axis, a ray cannot that grazes a wall, or starts next to one.
template <int D>
inline constexpr int kRays = D == 2 ? 1 : 3;

// Does ray number `ray` from p cross the wall? Nothing if that cannot be told, which is so at its
// corners and inside of it. In space p is not inside one of its edges. O(corners).
std::optional<bool> RayCrosses(int ray, const geometry::Point2& p, const Wall<2>& wall);
std::optional<bool> RayCrosses(int ray, const geometry::Point3& p, const Wall<3>& wall);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_WALL_H_
