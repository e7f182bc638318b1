#include "core/geometry/facet_plane.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "core/geometry/products.h"

namespace dynmesh::geometry {
namespace {

// The axis of the largest component, the first of several.
int LargestAxis(const Vector3& v) {
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::fabs(v[i]) > std::fabs(v[axis])) axis = i;
  }
  return axis;
}

// Twice the ring's area along its normal, with the largest component positive.
Vector3 AreaVector(const std::vector<Point3>& ring) {
  const std::size_t n = ring.size();
  const auto least =
      static_cast<std::size_t>(std::min_element(ring.begin(), ring.end()) - ring.begin());
  const bool forward = ring[(least + 1) % n] < ring[(least + n - 1) % n];
  const auto at = [&](std::size_t i) { return ring[(least + (forward ? i : n - i)) % n]; };
  Vector3 sum = {0, 0, 0};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Vector3 c = AccurateCross(Difference(at(i).c, at(0).c), Difference(at(i + 1).c, at(0).c));
    for (int k = 0; k < 3; ++k) sum[k] += c[k];
  }
  if (sum[LargestAxis(sum)] < 0) {
    for (double& x : sum) x = -x;
  }
  return sum;
}

}  // namespace

FacetPlane PlaneOf(const std::vector<std::vector<Point3>>& rings) {
  FacetPlane plane;
  Vector3 best = {0, 0, 0};
  plane.origin = rings.front().front();
  for (const std::vector<Point3>& ring : rings) {
    const Vector3 v = AreaVector(ring);
    if (std::tuple(Dot(v, v), v) > std::tuple(Dot(best, best), best)) best = v;
    plane.origin = std::min(plane.origin, *std::min_element(ring.begin(), ring.end()));
  }
  const double length = std::sqrt(Dot(best, best));
  if (!(length > 0)) return plane;
  plane.area = length / 2;
  plane.drop = LargestAxis(best);
  for (int k = 0; k < 3; ++k) plane.normal[k] = best[k] / length;
  double lo = 0, hi = 0;  // the least corner is at 0
  for (const std::vector<Point3>& ring : rings) {
    for (const Point3& p : ring) {
      const double d = plane.Distance(p);
      lo = std::min(lo, d), hi = std::max(hi, d);
    }
  }
  plane.offset = (lo + hi) / 2;
  plane.deviation = (hi - lo) / 2;
  return plane;
}

}  // namespace dynmesh::geometry
