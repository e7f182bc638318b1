#include "core/meshing/polygon_area.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::meshing::polygon_area_test {
namespace {

using geometry::Point2;
using Ring = std::vector<Point2>;

double DistanceToEdge(const Point2& p, const Point2& a, const Point2& b) {
  const double dx = b[0] - a[0], dy = b[1] - a[1];
  const double t =
      std::clamp(((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return std::hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy);
}

// By the winding of every edge; *margin gets the distance of the verdict from changing.
bool NaiveMeets(const std::vector<Ring>& rings, const Point2& p, double radius, double* margin) {
  bool inside = false;
  double nearest = INFINITY;
  for (const Ring& ring : rings) {
    double turn = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
      nearest = std::min(nearest, DistanceToEdge(p, a, b));
      const double ax = a[0] - p[0], ay = a[1] - p[1], bx = b[0] - p[0], by = b[1] - p[1];
      turn += std::atan2(ax * by - ay * bx, ax * bx + ay * by);
    }
    if (std::lround(turn / (2 * std::numbers::pi)) % 2 != 0) inside = !inside;
  }
  *margin = inside ? std::max(nearest, radius - nearest) : std::fabs(nearest - radius);
  return inside || nearest <= radius;
}

// A ring around (x, y) that does not cross itself.
Ring StarShaped(test::Random& random, double x, double y, double size, int corners) {
  Ring ring;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners, r = size * (0.2 + random.Unit());
    ring.push_back({{x + r * std::cos(angle), y + r * std::sin(angle)}});
  }
  return ring;
}

TEST(PolygonArea, MeetsWhatALookAtEveryEdgeSays) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    test::Random random(seed);
    std::vector<Ring> rings = {StarShaped(random, 0, 0, 1, 3 + random.Below(200))};
    if (random.OneIn(2)) rings.push_back(StarShaped(random, 0.05, 0, 0.1, 3 + random.Below(30)));
    if (random.OneIn(2)) rings.push_back(StarShaped(random, 3, 1, 0.5, 3 + random.Below(9)));
    const PolygonArea area(rings);
    for (int i = 0; i < 300; ++i) {
      const Point2 p{{5 * random.Unit() - 1.5, 3 * random.Unit() - 1.5}};
      const double radius = random.OneIn(3) ? 0 : std::ldexp(random.Unit(), -random.Below(8));
      double margin = 0;
      const bool meets = NaiveMeets(rings, p, radius, &margin);
      if (margin < 1e-9) continue;
      ASSERT_EQ(area.Meets(p, radius), meets) << "seed " << seed << ", query " << i;
    }
  }
}

TEST(PolygonArea, DoesNotDependOnWhereARingBeginsOrWhichWayItGoes) {
  test::Random random(7);
  std::vector<Ring> rings = {StarShaped(random, 0, 0, 1, 37), StarShaped(random, 0, 0, 0.1, 11)};
  const PolygonArea one(rings);
  std::swap(rings[0], rings[1]);
  for (Ring& ring : rings) {
    std::rotate(ring.begin(), ring.begin() + 4, ring.end());
    std::reverse(ring.begin(), ring.end());
  }
  const PolygonArea other(rings);
  for (int i = 0; i < 20'000; ++i) {
    // On corners and edges as well: there rounding decides.
    const Ring& ring = rings[static_cast<std::size_t>(random.Below(2))];
    const auto k = static_cast<std::size_t>(random.Below(static_cast<int>(ring.size())));
    const Point2 &a = ring[k], &b = ring[(k + 1) % ring.size()];
    const double t = random.Below(5) / 4.0;
    const Point2 p{{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])}};
    const double radius = random.OneIn(2) ? 0 : DistanceToEdge(p, rings[0][0], rings[0][1]);
    ASSERT_EQ(one.Meets(p, radius), other.Meets(p, radius)) << "query " << i;
  }
}

}  // namespace
}  // namespace dynmesh::meshing::polygon_area_test
