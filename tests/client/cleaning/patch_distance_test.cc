#include "client/cleaning/patch_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>
#include <vector>

#include "tests/client/cleaning/sampled_distance.h"

namespace dynmesh::cleaning::patch_distance_test {
namespace {

constexpr std::uint64_t kSeed = 17;

TEST(PatchDistance, TheNearestPointIsThatOfTheOracle) {
  SoupMaker maker(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const TriangleCorners t = {maker.Place(0, 1), maker.Place(0, 1), maker.Place(0, 1)};
    const Point3 p = maker.Place(-1, 2);
    EXPECT_NEAR(std::sqrt(SquaredDistance<3>(NearestOn(t, p), p)), DistanceTo(p, t), 1e-9)
        << "seed " << kSeed << ", " << i;
  }
}

// A flat square of n x n squares of two triangles, and a triangle over many of them.
TEST(PatchDistance, ATriangleOverManyOthersIsNear) {
  for (const int n : {1, 3, 20}) {
    std::vector<DistanceTarget> targets;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const double x = i, y = j;
        targets.emplace_back(TriangleCorners{{{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}}});
        targets.emplace_back(TriangleCorners{{{x, y, 0}, {x, y + 1, 0}, {x + 1, y + 1, 0}}});
      }
    }
    const double end = n;
    const TriangleCorners over = {{{0, 0, 0.1}, {end, 0, 0.1}, {0.2 * end, end, 0.1}}};
    std::vector<std::uint32_t> used;
    EXPECT_TRUE(IsWithin(over, targets, 0.1001, used));
    EXPECT_FALSE(used.empty());
    EXPECT_FALSE(IsWithin(over, targets, 0.0999, used));
    const TriangleCorners beyond = {{{0, 0, 0}, {end + 0.2, 0, 0}, {0.2 * end, end, 0}}};
    EXPECT_FALSE(IsWithin(beyond, targets, 0.1, used));
    EXPECT_TRUE(IsWithin(beyond, targets, 0.2001, used));
    // One is missing, in the middle.
    if (n > 2) {
      targets.erase(targets.begin() + 2 * (n / 2 * n + n / 2));
      EXPECT_FALSE(IsWithin(over, targets, 0.12, used));
    }
  }
}

TEST(PatchDistance, WhatIsProvedHoldsForSamples) {
  std::cout << "seed " << kSeed << "\n";
  SoupMaker maker(kSeed);
  int proved = 0, refuted = 0;
  for (int round = 0; round < 300; ++round) {
    PlainSurface surface, piece;
    std::vector<DistanceTarget> targets;
    for (int i = 0; i < 12; ++i) {
      TriangleCorners t = {maker.Place(0, 1), maker.Place(0, 1), maker.Place(0, 1)};
      for (Point3& p : t) p[2] *= 0.1;
      targets.emplace_back(t);
      surface.triangles.push_back(t);
    }
    TriangleCorners t = {maker.Place(0.2, 0.8), maker.Place(0.2, 0.8), maker.Place(0.2, 0.8)};
    for (Point3& p : t) p[2] *= 0.1;
    piece.triangles.push_back(t);
    const double farthest = FarthestFrom(piece, surface);
    for (const double distance : {0.05, 0.1}) {
      std::vector<std::uint32_t> used;
      if (IsWithin(t, targets, distance, used)) {
        ++proved;
        EXPECT_LE(farthest, distance * (1 + 1e-9)) << round;
        // Those that the proof needs are enough.
        PlainSurface needed;
        for (const std::uint32_t k : used) needed.triangles.push_back(surface.triangles[k]);
        EXPECT_LE(FarthestFrom(piece, needed), distance * (1 + 1e-9)) << round;
      } else {
        ++refuted;
      }
    }
  }
  EXPECT_GT(proved, 100);
  EXPECT_GT(refuted, 20);
}

}  // namespace
}  // namespace dynmesh::cleaning::patch_distance_test
