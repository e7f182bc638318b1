// Planes of polygons: the same for any form of the rings.
#include "core/geometry/facet_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::geometry::facet_plane_test {
namespace {

constexpr std::uint64_t kSeed = 20261121;

// A star-shaped ring about a point of a plane, and one inside it.
std::vector<Ring3> RandomRings(test::Random& random) {
  const Vector3 n = {random.Unit() - 0.5, random.Unit() - 0.5, random.Unit() - 0.5};
  const Vector3 u = Cross(n, {0.3, 0.5, 0.7}), v = Cross(n, u);
  const double scale = 1 / std::sqrt(Dot(u, u)), other = 1 / std::sqrt(Dot(v, v));
  std::vector<Ring3> rings;
  for (const double size : {1.0, 0.3}) {
    Ring3& ring = rings.emplace_back();
    const int corners = 3 + random.Below(8);
    for (int i = 0; i < corners; ++i) {
      const double turn = 6.283185307179586 * (i + 0.5 * random.Unit()) / corners;
      const double r = size * (0.7 + 0.3 * random.Unit());
      const double a = r * std::cos(turn) * scale, b = r * std::sin(turn) * other;
      ring.push_back({{5 + a * u[0] + b * v[0], 5 + a * u[1] + b * v[1], 5 + a * u[2] + b * v[2]}});
    }
  }
  return rings;
}

TEST(FacetPlane, DoesNotDependOnHowRingsAreWritten) {
  test::Random random(kSeed);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", round " + std::to_string(round));
    std::vector<Ring3> rings = RandomRings(random);
    const FacetPlane plane = PlaneOf(rings);
    EXPECT_NEAR(Dot(plane.normal, plane.normal), 1, 1e-14);
    EXPECT_GT(plane.normal[plane.axis], 0);
    for (const Ring3& ring : rings) {
      for (const Point3& p : ring) EXPECT_NEAR(plane.Height(p), 0, 1e-14);
    }
    for (Ring3& ring : rings) {
      std::rotate(ring.begin(), ring.begin() + random.Below(static_cast<int>(ring.size())),
                  ring.end());
      if (random.OneIn(2)) std::reverse(ring.begin(), ring.end());
    }
    if (random.OneIn(2)) std::swap(rings[0], rings[1]);
    const FacetPlane again = PlaneOf(rings);
    EXPECT_EQ(plane.origin, again.origin);
    EXPECT_EQ(plane.normal, again.normal);
    EXPECT_EQ(plane.axis, again.axis);
  }
}

TEST(FacetPlane, HasHeightsAndFeet) {
  const std::vector<Ring3> rings = {{{{0, 0, 2}}, {{8, 0, 2}}, {{8, 8, 2}}, {{0, 8, 2}}}};
  const FacetPlane plane = PlaneOf(rings);
  EXPECT_EQ(plane.axis, 2);
  EXPECT_EQ(plane.normal, (Vector3{0, 0, 1}));
  EXPECT_EQ(plane.Height({{1, 1, 5}}), 3);
  EXPECT_EQ(plane.Foot({{1, 1, 5}}), (Point3{{1, 1, 2}}));
}

}  // namespace
}  // namespace dynmesh::geometry::facet_plane_test
