// Rays that cross the faces of turned boxes, against the point's position in the box's own axes.
#include "core/regions/wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::wall_test {
namespace {

using geometry::Point3;

// From the box's axes to the mesh's, turned about two of these.
Point3 Turned(const Point3& p, double turn) {
  const double c = std::cos(turn), s = std::sin(turn);
  const Point3 q = {{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]}};
  return {{q[0], c * q[1] - s * q[2], s * q[1] + c * q[2]}};
}

// The faces of a cube from -1 to 1.
std::vector<Wall<3>> WallsOfCube(double turn) {
  std::vector<Wall<3>> walls;
  for (int k = 0; k < 3; ++k) {
    for (const double side : {-1.0, 1.0}) {
      geometry::Ring3 ring;
      for (const auto& [u, v] :
           {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        Point3 p;
        p[k] = side, p[(k + 1) % 3] = u, p[(k + 2) % 3] = v;
        ring.push_back(Turned(p, turn));
      }
      walls.emplace_back(std::vector<geometry::Ring3>{ring}, std::vector<FeatureId>{7});
    }
  }
  return walls;
}

TEST(Wall, RaysThatTellSayWhatIsInside) {
  constexpr std::uint64_t kSeed = 5;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  test::Random random(kSeed);
  int told = 0, inside = 0;
  for (int i = 0; i < 2000; ++i) {
    const double turn = i % 4 == 0 ? 0 : 3 * random.Unit();
    const std::vector<Wall<3>> walls = WallsOfCube(turn);
    Point3 p;  // every other one in line with edges and corners of a cube that is not turned
    for (int k = 0; k < 3; ++k)
      p[k] = i % 2 == 0 ? 0.5 * random.Below(9) - 2 : 4 * random.Unit() - 2;
    // On a face the result is unspecified.
    if (std::max({std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])}) == 1) continue;
    const bool is_inside = std::max({std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])}) < 1;
    for (int ray = 0; ray < kRays<3>; ++ray) {
      bool odd = false, tells = true;
      for (const Wall<3>& wall : walls) {
        const std::optional<bool> crosses = RayCrosses(ray, Turned(p, turn), wall);
        tells = tells && crosses.has_value();
        odd ^= crosses.value_or(false);
      }
      if (!tells) continue;
      ++told, inside += is_inside;
      ASSERT_EQ(odd, is_inside) << "place " << i << ", ray " << ray << ", turn " << turn;
    }
  }
  EXPECT_GT(told, 5000);
  EXPECT_GT(inside, 400);
}

TEST(Wall, IsNotCrossedInItsHole) {
  constexpr std::uint64_t kSeed = 6;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  test::Random random(kSeed);
  const auto square = [](double half) {
    return geometry::Ring3{Point3{{-half, -half, 0}}, Point3{{half, -half, 0}},
                           Point3{{half, half, 0}}, Point3{{-half, half, 0}}};
  };
  const Wall<3> wall({square(1), square(0.5)}, {7});
  constexpr int kUp = 2;
  int crossed = 0;
  for (int i = 0; i < 500; ++i) {
    const double x = 3 * random.Unit() - 1.5, y = 3 * random.Unit() - 1.5;
    const double z = 2 * random.Unit() - 1, off = std::max(std::fabs(x), std::fabs(y));
    const bool crosses = z < 0 && 0.5 < off && off < 1;
    ASSERT_EQ(RayCrosses(kUp, Point3{{x, y, z}}, wall), crosses) << x << " " << y << " " << z;
    crossed += crosses;
  }
  EXPECT_GT(crossed, 50);
}

TEST(Wall, NothingIsToldOnOne) {
  const double turn = 0.4;
  const std::vector<Wall<3>> walls = WallsOfCube(turn);
  for (const Point3& p : {Point3{{1, 1, 1}}, Point3{{1, 0.25, -0.5}}, Point3{{0.5, -1, 0}}}) {
    for (int ray = 0; ray < kRays<3>; ++ray) {
      bool tells = true;
      for (const Wall<3>& wall : walls) {
        tells = tells && RayCrosses(ray, Turned(p, turn), wall).has_value();
      }
      EXPECT_FALSE(tells) << "ray " << ray;
    }
  }
}

}  // namespace
}  // namespace dynmesh::wall_test
