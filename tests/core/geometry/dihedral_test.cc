// Dihedral angles beside a bound, against angles by atan2 of each pair of faces.
#include "core/geometry/dihedral.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/apex_bound.h"
#include "tests/core/geometry/random_points.h"

namespace dynmesh::geometry::dihedral_test {
namespace {

using Corners = std::array<Point3, 4>;

// At the edge from a to b, between c and d: seen along the edge.
double NaiveAngle(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const Vector3 edge = Difference(b.c, a.c);
  const Vector3 u = Cross(edge, Difference(c.c, a.c)), w = Cross(edge, Difference(d.c, a.c));
  const Vector3 across = Cross(u, w);
  return std::atan2(std::sqrt(Dot(across, across)), Dot(u, w)) * 180 / std::numbers::pi;
}

double NaiveLeast(const Corners& p) {
  double least = 180;
  for (const auto& [a, b, c, d] : {std::array{0, 1, 2, 3},
                                   {0, 2, 1, 3},
                                   {0, 3, 1, 2},
                                   {1, 2, 0, 3},
                                   {1, 3, 0, 2},
                                   {2, 3, 0, 1}}) {
    least = std::min(least, NaiveAngle(p[a], p[b], p[c], p[d]));
  }
  return least;
}

TEST(Dihedral, IsBelowWhereSomeAngleIs) {
  constexpr std::uint64_t kSeed = 5;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> within(0, 1);
  int below = 0;
  for (int n = 0; n < 20'000; ++n) {
    Corners p;
    for (Point3& x : p) {
      for (double& c : x.c) c = within(random);
    }
    if (n % 3 == 0) p[3][2] = p[0][2] = p[1][2] = p[2][2] + 0.05 * within(random);  // nearly flat
    const double least = NaiveLeast(p);
    for (const double degrees : {1.0, 5.0, 10.0, 20.0, 30.0}) {
      if (std::abs(least - degrees) < 1e-6) continue;
      const bool is_below = DihedralBound(degrees).IsBelow(p);
      ASSERT_EQ(is_below, least < degrees) << least << " beside " << degrees;
      below += is_below;
    }
  }
  EXPECT_GT(below, 10'000);
}

TEST(Dihedral, IsTheSameInWhateverOrderCornersCome) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> within(0, 1);
  for (int n = 0; n < 500; ++n) {
    Corners p;
    for (Point3& x : p) {
      for (double& c : x.c) c = within(random);
    }
    // A bound that is one of the angles, so that rounding decides.
    const DihedralBound bound(std::min(30.0, NaiveLeast(p)));
    std::array<int, 4> order = {0, 1, 2, 3};
    const bool first = bound.IsBelow(p);
    do {
      EXPECT_EQ(bound.IsBelow({p[order[0]], p[order[1]], p[order[2]], p[order[3]]}), first);
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

// In whatever order corners come, and mostly it is certain.
TEST(Dihedral, WhatIsCertainIsWhatSortedCornersSay) {
  using Certain = DihedralBound::Certain;
  int certain = 0, uncertain = 0;
  for (const testing::Kind kind : testing::kAllKinds) {
    testing::PointSource<3> source(kind, 7);
    for (int run = 0; run < 300; ++run) {
      Corners p;
      for (Point3& corner : p) corner = source.Next();
      for (const double degrees : {0.01, 10.0, 30.0}) {
        const DihedralBound bound(degrees);
        const bool is_below = bound.IsBelow(p);
        std::array<int, 4> order = {0, 1, 2, 3};
        do {
          const Corners q = {p[order[0]], p[order[1]], p[order[2]], p[order[3]]};
          const Certain found = bound.Look(q, [](int, int) { return true; });
          EXPECT_TRUE(found == Certain::kUnsure || (found == Certain::kOne) == is_below);
          ++(found == Certain::kUnsure ? uncertain : certain);
          EXPECT_NE(bound.Look(q, [](int, int) { return false; }), Certain::kOne);
        } while (std::next_permutation(order.begin(), order.end()));
      }
    }
  }
  EXPECT_GT(certain, uncertain);
}

// Of flat ones and needles, too; and of most where an angle at the triangle is well below.
TEST(ApexBound, WhatIsSureIsBelow) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> within(0, 1);
  int sure = 0, well_below = 0, found = 0;
  const auto check = [&](const Corners& p) {
    for (const double degrees : {0.0, 0.01, 1.0, 10.0, 30.0}) {
      const DihedralBound bound(degrees);
      const ApexBound of(bound, {p[0], p[1], p[2]});
      const bool is_sure = of.IsSurelyBelow(p[3]);
      if (is_sure) {
        EXPECT_GE(degrees, 1);
        std::array<int, 4> order = {0, 1, 2, 3};
        do {
          const Corners q = {p[order[0]], p[order[1]], p[order[2]], p[order[3]]};
          ASSERT_TRUE(bound.IsBelow(q)) << degrees;
          ASSERT_NE(bound.Look(q, [](int, int) { return true; }), DihedralBound::Certain::kNone);
        } while (std::next_permutation(order.begin(), order.end()));
      }
      sure += is_sure;
      if (degrees < 1) continue;
      const double least =
          std::min({NaiveAngle(p[0], p[1], p[2], p[3]), NaiveAngle(p[1], p[2], p[0], p[3]),
                    NaiveAngle(p[2], p[0], p[1], p[3])});
      well_below += least < 0.98 * degrees;
      found += least < 0.98 * degrees && is_sure;
    }
  };
  for (const testing::Kind kind : testing::kAllKinds) {
    testing::PointSource<3> source(kind, 7);
    for (int run = 0; run < 300; ++run) {
      Corners p;
      for (Point3& corner : p) corner = source.Next();
      check(p);
    }
  }
  EXPECT_GT(sure, 100);
  well_below = found = 0;
  for (int run = 0; run < 20'000; ++run) {
    Corners p;
    for (Point3& corner : p) {
      for (double& c : corner.c) c = within(random);
    }
    const double width = std::pow(10, -8 * within(random));
    switch (run % 4) {
      case 1:  // over a needle
        for (int k = 0; k < 3; ++k) p[1][k] = p[0][k] + width * (p[1][k] - p[0][k]);
        break;
      case 2:  // near a corner
        for (int k = 0; k < 3; ++k) p[3][k] = p[0][k] + width * (p[3][k] - p[0][k]);
        break;
      case 3:  // near the plane
        for (int k = 0; k < 3; ++k) {
          const double in_plane = 0.3 * p[0][k] + 0.5 * p[1][k] + 0.2 * p[2][k];
          p[3][k] = in_plane + width * (p[3][k] - in_plane);
        }
        break;
      default:
        break;
    }
    check(p);
  }
  EXPECT_GT(2 * found, well_below);
}

TEST(Dihedral, FlatIsBelow) {
  const Corners square = {{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{1, 1, 0}}}};
  const Corners line = {{{{0, 0, 0}}, {{1, 0, 0}}, {{2, 0, 0}}, {{3, 0, 0}}}};
  EXPECT_TRUE(DihedralBound(1e-9).IsBelow(square));
  EXPECT_TRUE(DihedralBound(1e-9).IsBelow(line));
}

// A regular tetrahedron: 70.53 degrees. The corner of a cube: 54.74 and 90. At any scale.
TEST(Dihedral, OfKnownTetrahedra) {
  for (const double scale : {1e-40, 1.0, 1e40}) {
    const auto at = [scale](double x, double y, double z) {
      return Point3{{scale * x, scale * y, scale * z}};
    };
    const Corners regular = {{at(1, 1, 1), at(1, -1, -1), at(-1, 1, -1), at(-1, -1, 1)}};
    const Corners wedge = {{at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 0.1)}};  // 8.05
    EXPECT_FALSE(DihedralBound(30).IsBelow(regular));
    EXPECT_FALSE(DihedralBound(8.04).IsBelow(wedge));
    EXPECT_TRUE(DihedralBound(8.06).IsBelow(wedge));
  }
}

}  // namespace
}  // namespace dynmesh::geometry::dihedral_test
