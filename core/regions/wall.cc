#include "core/regions/wall.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/predicates.h"
#include "core/regions/region_terms.h"

namespace dynmesh {
namespace {

using geometry::Point2;
using geometry::Point3;

// A ray grazes a wall if the sine of its angle to the wall's plane is smaller than this. A position
// is undecided if its distance to the wall's plane is less than this share of its distance from the
// wall's least corner. Doubles would allow far less; an undecided ray is replaced by another.
constexpr double kGrazes = 1e-3;
constexpr double kNear = 1e-10;

// Is p, moved right and much less up, in the projection of the wall along the axis?
bool IsInShadow(const Point3& p, const Wall<3>& wall, int axis) {
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  if (p[x] < wall.lo[x] || p[x] > wall.hi[x] || p[y] < wall.lo[y] || p[y] > wall.hi[y]) {
    return false;
  }
  const auto shadow = [&](const Point3& q) { return Point2{{q[x], q[y]}}; };
  bool inside = false;
  for (const geometry::Ring3& ring : wall.rings) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      inside ^= geometry::CrossesEdge(shadow(p), shadow(ring[i]), shadow(ring[j])).value_or(false);
    }
    if (!IsOn(RegionTerm::kHolesOfWalls)) break;
  }
  return inside;
}

bool IsCorner(const Point3& p, const Wall<3>& wall) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (p[k] < wall.lo[k] || wall.hi[k] < p[k]) return false;
  }
  return std::any_of(wall.rings.begin(), wall.rings.end(), [&](const geometry::Ring3& ring) {
    return std::find(ring.begin(), ring.end(), p) != ring.end();
  });
}

}  // namespace

Wall<3>::Wall(std::vector<geometry::Ring3> its_rings, std::vector<FeatureId> its_owners)
    : rings(std::move(its_rings)), owners(std::move(its_owners)), plane(geometry::PlaneOf(rings)) {
  const geometry::FacetBounds bounds = geometry::BoundsOf(rings, plane);
  thickness = 2 * bounds.deviation;
  lo = bounds.lo;
  hi = bounds.hi;
}

std::optional<bool> RayCrosses(int, const Point2& p, const Wall<2>& wall) {
  return geometry::CrossesEdge(p, wall.p, wall.q);
}

std::optional<bool> RayCrosses(int ray, const Point3& p, const Wall<3>& wall) {
  if (IsCorner(p, wall)) return std::nullopt;
  // The ray goes up along the axis: a wall below is not crossed, whatever its projection.
  const int axis = ray;
  if (p[axis] > wall.hi[axis] || !IsInShadow(p, wall, axis)) return false;
  if (p[axis] < wall.lo[axis]) return true;
  const double height = wall.plane.Height(p);
  const double slope = wall.plane.normal[axis];
  const double distance = std::sqrt(geometry::SquaredDistance(p, wall.plane.origin));
  if (!(std::fabs(height) > wall.thickness + kNear * distance)) return std::nullopt;
  if (!(std::fabs(slope) > kGrazes)) return std::nullopt;
  return (height < 0) == (slope > 0);
}

}  // namespace dynmesh
