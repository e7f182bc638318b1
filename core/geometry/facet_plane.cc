#include "core/geometry/facet_plane.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace dynmesh::geometry {
namespace {

// Twice the vector area, summed from the least corner towards its lesser neighbour.
Vector3 AreaOf(const Ring3& ring, const Point3& least, std::size_t at) {
  const std::size_t n = ring.size();
  const bool forward = ring[(at + 1) % n] < ring[(at + n - 1) % n];
  const auto corner = [&](std::size_t i) {
    return Difference(ring[forward ? (at + i) % n : (at + n - i) % n].c, least.c);
  };
  Vector3 sum = {0, 0, 0};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Vector3 c = Cross(corner(i), corner(i + 1));
    for (int k = 0; k < 3; ++k) sum[k] += c[k];
  }
  return sum;
}

}  // namespace

std::array<Vector3, 2> AxesOf(const FacetPlane& plane) {
  Vector3 first = {0, 0, 0};
  const int k = (plane.axis + 1) % 3;
  for (int i = 0; i < 3; ++i) first[i] = (i == k ? 1 : 0) - plane.normal[k] * plane.normal[i];
  const double length = std::sqrt(Dot(first, first));
  for (double& x : first) x /= length;
  return {first, Cross(plane.normal, first)};
}

FacetPlane PlaneOf(std::span<const Ring3> rings) {
  FacetPlane plane;
  double most = -1;
  for (const Ring3& ring : rings) {
    const auto least = std::min_element(ring.begin(), ring.end());
    const Vector3 area = AreaOf(ring, *least, static_cast<std::size_t>(least - ring.begin()));
    const double size2 = Dot(area, area);
    if (size2 < most || (size2 == most && plane.origin < *least)) continue;
    most = size2;
    plane.origin = *least;
    plane.normal = area;
  }
  for (int k = 1; k < 3; ++k) {
    if (std::fabs(plane.normal[k]) > std::fabs(plane.normal[plane.axis])) plane.axis = k;
  }
  const double length = std::copysign(std::sqrt(most), plane.normal[plane.axis]);
  for (double& n : plane.normal) n /= length;
  return plane;
}

FacetBounds BoundsOf(std::span<const Ring3> rings, const FacetPlane& plane) {
  FacetBounds bounds{plane.origin, plane.origin, 0};
  for (const Ring3& ring : rings) {
    for (const Point3& p : ring) {
      bounds.deviation = std::max(bounds.deviation, std::fabs(plane.Height(p)));
      for (int k = 0; k < 3; ++k) {
        bounds.lo[k] = std::min(bounds.lo[k], p[k]);
        bounds.hi[k] = std::max(bounds.hi[k], p[k]);
      }
    }
  }
  return bounds;
}

}  // namespace dynmesh::geometry
