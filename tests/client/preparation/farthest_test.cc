#include "client/preparation/farthest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/seed.h"

namespace dynmesh::preparation {
namespace {

using Place = std::array<double, 3>;

Feature PointAt(FeatureId id, const Place& p) { return Feature::Point(id, p[0], p[1], p[2]); }

std::vector<Feature> SegmentsOf(const std::vector<std::array<Place, 2>>& segments) {
  std::vector<Feature> features;
  FeatureId id = 0;
  for (const auto& [p, q] : segments) {
    features.push_back(PointAt(id + 1, p));
    features.push_back(PointAt(id + 2, q));
    features.push_back(Feature::Segment(id + 3, id + 1, id + 2));
    id += 3;
  }
  return features;
}

std::vector<Feature> PolygonsOf(const std::vector<std::array<Place, 3>>& triangles) {
  std::vector<Feature> features;
  FeatureId id = 0;
  for (const auto& corners : triangles) {
    for (const Place& p : corners) features.push_back(PointAt(++id, p));
    features.push_back(Feature::Polygon(id + 1, {{id - 2, id - 1, id}}));
    ++id;
  }
  return features;
}

double DistanceToSegment(const Place& x, const Place& p, const Place& q) {
  double along = 0, length = 0, sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    along += (x[k] - p[k]) * (q[k] - p[k]), length += (q[k] - p[k]) * (q[k] - p[k]);
  }
  const double t = std::clamp(along / length, 0.0, 1.0);
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = x[k] - p[k] - t * (q[k] - p[k]);
    sum += d * d;
  }
  return std::sqrt(sum);
}

TEST(FarthestBound, OfTheSameIsTheLeast) {
  const auto set = SegmentsOf({{{{0, 0, 0}, {1, 0, 0}}}, {{{1, 0, 0}, {1, 1, 0}}}});
  EXPECT_EQ(FarthestBound(set, set, 2, 1e-9, 1e-3), 1e-9);
}

TEST(FarthestBound, PartsOfAnEdgeAreOnIt) {
  const auto whole = SegmentsOf({{{{0, 0, 0}, {3, 1, 0}}}});
  const auto parts = SegmentsOf({{{{0, 0, 0}, {1.5, 0.5, 0}}}, {{{1.5, 0.5, 0}, {3, 1, 0}}}});
  EXPECT_EQ(FarthestBound(whole, parts, 2, 1e-9, 1e-3), 1e-9);
  EXPECT_EQ(FarthestBound(parts, whole, 2, 1e-9, 1e-3), 1e-9);
}

TEST(FarthestBound, AMissingPartIsFound) {
  const auto whole = SegmentsOf({{{{0, 0, 0}, {3, 0, 0}}}});
  const auto parts = SegmentsOf({{{{0, 0, 0}, {1, 0, 0}}}, {{{1.1, 0, 0}, {3, 0, 0}}}});
  EXPECT_FALSE(FarthestBound(whole, parts, 2, 1e-9, 0.049));
  const auto bound = FarthestBound(whole, parts, 2, 1e-9, 0.2);
  ASSERT_TRUE(bound);
  EXPECT_GE(*bound, 0.05);
}

// The distance by samples is at most the bound, and half of the bound is at most the distance of
// some sample, up to their step.
TEST(FarthestBound, OfRandomSegmentsIsThatOfSamples) {
  std::mt19937_64 random(test::NewSeed());
  std::uniform_real_distribution<double> at(0, 1);
  for (int run = 0; run < 200; ++run) {
    std::vector<std::array<Place, 2>> from(1), to(8);
    for (auto* set : {&from, &to}) {
      for (auto& segment : *set) {
        for (Place& p : segment) p = {at(random), at(random), 0};
      }
    }
    double farthest = 0;
    constexpr int kSamples = 2000;
    for (int i = 0; i <= kSamples; ++i) {
      Place x{};
      for (std::size_t k = 0; k < 3; ++k) {
        x[k] = from[0][0][k] + (from[0][1][k] - from[0][0][k]) * i / kSamples;
      }
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& [p, q] : to) nearest = std::min(nearest, DistanceToSegment(x, p, q));
      farthest = std::max(farthest, nearest);
    }
    const auto bound = FarthestBound(SegmentsOf(from), SegmentsOf(to), 2, 1e-6, 2);
    ASSERT_TRUE(bound);
    EXPECT_GE(*bound, farthest) << run;
    EXPECT_LE(*bound / 2, std::max(farthest * 1.1 + 1e-3, 1e-6)) << run;
  }
}

TEST(FarthestBound, OfAFaceThatIsLifted) {
  const auto flat = PolygonsOf({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}});
  const auto lifted = PolygonsOf({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0.001}}}});
  const auto bound = FarthestBound(lifted, flat, 3, 1e-9, 0.01);
  ASSERT_TRUE(bound);
  EXPECT_GE(*bound, 0.001);
  EXPECT_LE(*bound, 0.002001);
  EXPECT_FALSE(FarthestBound(lifted, flat, 3, 1e-9, 0.0009));
}

TEST(FarthestBound, PartsOfAFaceAreOnIt) {
  const auto whole = PolygonsOf({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}});
  const auto parts = PolygonsOf({{{{0, 0, 0}, {1, 0, 0}, {0.25, 0.25, 0}}},
                                 {{{1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 0}}},
                                 {{{0, 1, 0}, {0, 0, 0}, {0.25, 0.25, 0}}}});
  const auto bound = FarthestBound(whole, parts, 3, 1e-9, 1e-6);
  ASSERT_TRUE(bound);
  EXPECT_LE(*bound, 2e-9);
  EXPECT_FALSE(
      FarthestBound(whole, PolygonsOf({{{{0, 0, 0}, {1, 0, 0}, {0.25, 0.25, 0}}}}), 3, 1e-9, 0.1));
}

}  // namespace
}  // namespace dynmesh::preparation
