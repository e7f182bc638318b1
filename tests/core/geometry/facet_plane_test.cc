// The plane of a facet: one for all who ask, near to what rationals say.
#include "core/geometry/facet_plane.h"

#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/geometry/predicates.h"

namespace dynmesh::geometry {
namespace {

using Rings = std::vector<std::vector<Point3>>;
using Exact = CGAL::Simple_cartesian<CGAL::Exact_rational>;

// A star-shaped ring and a smaller one in it, in a random plane, as near as doubles are.
Rings AnyFacet(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Vector3 u, v, o;
  for (int k = 0; k < 3; ++k) u[k] = unit(random), v[k] = unit(random), o[k] = 4 * unit(random);
  Rings rings;
  for (const double size : {1.0, 0.25}) {
    auto& ring = rings.emplace_back();
    const int n = 3 + static_cast<int>(random() % 9);
    for (int i = 0; i < n; ++i) {
      const double angle = 6.283185307179586 * i / n;
      const double r = size * (1 + 0.4 * unit(random)), x = r * std::cos(angle),
                   y = r * std::sin(angle);
      ring.push_back(
          {{o[0] + x * u[0] + y * v[0], o[1] + x * u[1] + y * v[1], o[2] + x * u[2] + y * v[2]}});
    }
  }
  return rings;
}

TEST(FacetPlane, IsAFunctionOfTheRingsHoweverTheyAreGiven) {
  const std::uint64_t seed = 71;
  std::mt19937_64 random(seed);
  for (int i = 0; i < 2000; ++i) {
    Rings rings = AnyFacet(random);
    const FacetPlane plane = PlaneOf(rings);
    for (auto& ring : rings) {
      std::rotate(ring.begin(), ring.begin() + static_cast<long>(random() % ring.size()),
                  ring.end());
      if (random() % 2 == 0) std::reverse(ring.begin(), ring.end());
    }
    std::shuffle(rings.begin(), rings.end(), random);
    const FacetPlane again = PlaneOf(rings);
    ASSERT_EQ(again.normal, plane.normal) << "seed " << seed << ", try " << i;
    ASSERT_EQ(again.origin, plane.origin);
    ASSERT_EQ(again.offset, plane.offset);
    ASSERT_EQ(again.deviation, plane.deviation);
    ASSERT_EQ(again.area, plane.area);
    ASSERT_EQ(again.drop, plane.drop);
  }
}

TEST(FacetPlane, IsExactAlongTheAxes) {
  const Rings rings = {{{{0.1, 0.7, 0.3}}, {{0.9, 0.7, 0.2}}, {{0.4, 0.7, 0.8}}}};
  const FacetPlane plane = PlaneOf(rings);
  EXPECT_EQ(plane.normal, (Vector3{0, 1, 0}));
  EXPECT_EQ(plane.deviation, 0);
  EXPECT_EQ(plane.drop, 1);
  EXPECT_EQ(plane.Distance({{5, 0.7, -3}}), 0);
  EXPECT_EQ(plane.Distance({{0, 0.95, 0}}), 0.95 - 0.7);
  EXPECT_NEAR(plane.area, 0.5 * (0.8 * 0.5 + 0.1 * 0.3), 1e-15);
}

TEST(FacetPlane, DistancesAreThoseOfRationals) {
  const std::uint64_t seed = 72;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-4, 4);
  for (int i = 0; i < 500; ++i) {
    Rings rings = AnyFacet(random);
    rings.resize(1);
    rings[0].resize(3);
    const FacetPlane plane = PlaneOf(rings);
    const auto of = [](const Point3& p) { return Exact::Point_3(p[0], p[1], p[2]); };
    const Point3 x = {{unit(random), unit(random), unit(random)}};
    const auto &a = rings[0][0], &b = rings[0][1], &c = rings[0][2];
    const Exact::Vector_3 n = CGAL::cross_product(of(b) - of(a), of(c) - of(a));
    const double wanted =
        CGAL::to_double(n * (of(x) - of(a))) / std::sqrt(CGAL::to_double(n.squared_length()));
    // Thin triangles know their plane less well far away.
    const double thin = plane.area / SquaredDistance(a, b);
    ASSERT_NEAR(std::fabs(plane.Distance(x)), std::fabs(wanted), 1e-13 / std::min(thin, 1.0))
        << "seed " << seed << ", try " << i;
    ASSERT_LT(plane.deviation, 1e-14 / std::min(thin, 1.0));
    ASSERT_LT(std::fabs(plane.Distance(plane.Foot(x))), 1e-14);
  }
}

TEST(FacetPlane, AProjectionKeepsWhatTurnsCounterClockwiseSeenFromTheNormal) {
  const std::uint64_t seed = 73;
  std::mt19937_64 random(seed);
  for (int i = 0; i < 500; ++i) {
    const Rings rings = AnyFacet(random);
    const FacetPlane plane = PlaneOf(rings);
    ASSERT_GT(plane.normal[plane.drop], 0.57);
    const Point3 &a = rings[0][0], &b = rings[0][1], &c = rings[0][2];
    const double turn = Dot(plane.normal, Cross(Difference(b.c, a.c), Difference(c.c, a.c)));
    if (std::fabs(turn) < 1e-9) continue;
    ASSERT_EQ(Orientation(plane.Project(a), plane.Project(b), plane.Project(c)) > 0, turn > 0)
        << "seed " << seed << ", try " << i;
  }
}

TEST(FacetPlane, ALineHasNone) {
  const FacetPlane plane = PlaneOf({{{{0, 0, 0}}, {{1, 1, 1}}, {{2, 2, 2}}}});
  EXPECT_EQ(plane.area, 0);
  EXPECT_EQ(plane.normal, (Vector3{0, 0, 0}));
}

}  // namespace
}  // namespace dynmesh::geometry
