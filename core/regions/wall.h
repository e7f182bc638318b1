// Walls that were added or removed. A wall separates two regions: an edge of polygons (2D) or a
// polygon that is part of a closed surface (3D).
//
// A ray from a position determines the change of its region: the owners of changed walls that it
// crosses an odd number of times. Exact predicates decide the projections along the ray. A position
// in line with an end or edge of a wall counts as moved aside by an infinitesimal amount, the same
// for all walls. So at a joint of two walls the ray crosses as many of them as a nearby ray would.
// Pure functions, thread-safe.
#ifndef DYNMESH_CORE_REGIONS_WALL_H_
#define DYNMESH_CORE_REGIONS_WALL_H_

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

// Planar up to its thickness: corners are off the plane by less than that.
template <>
struct Wall<3> {
  Wall(std::vector<geometry::Ring3> rings, std::vector<FeatureId> owners);

  std::vector<geometry::Ring3> rings;
  std::vector<FeatureId> owners;  // closed surfaces that it is or was part of, ascending
  geometry::FacetPlane plane;
  double thickness;
  geometry::Point3 lo, hi;
};

// The rays to choose from. All that can decide agree. In 3D, a ray along an axis cannot decide if
// it grazes a wall or starts close to one.
template <int D>
inline constexpr int kRays = D == 2 ? 1 : 3;

// Does ray number `ray` from p cross the wall? Nothing if undecided, as at the wall's corners and
// in its inside. In 3D, p must not be inside one of its edges. O(corners).
std::optional<bool> RayCrosses(int ray, const geometry::Point2& p, const Wall<2>& wall);
std::optional<bool> RayCrosses(int ray, const geometry::Point3& p, const Wall<3>& wall);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_REGIONS_WALL_H_
