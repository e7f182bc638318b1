// The local feature size, against all pairs of features.
#include "core/quality/local_feature_size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/segment_distance.h"
#include "dynmesh/quality.h"

namespace dynmesh::quality {
namespace {

using geometry::Point3;

double Distance(const Point3& a, const Point3& b) {
  return std::sqrt(geometry::SquaredDistance(a, b));
}

// Of triangle abc, by its parameters in small steps: a little too much.
double DistanceToTriangle(const Point3& x, const Point3& a, const Point3& b, const Point3& c) {
  double least = std::numeric_limits<double>::infinity();
  constexpr int kSteps = 60;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      Point3 p;
      for (int k = 0; k < 3; ++k) {
        p[k] = a[k] + (b[k] - a[k]) * i / kSteps + (c[k] - a[k]) * j / kSteps;
      }
      least = std::min(least, Distance(x, p));
    }
  }
  return least;
}

struct Part {
  std::vector<FeatureId> points;
  std::vector<Point3> corners;  // 1 to 3
};

double NaiveAt(const std::vector<Part>& parts, const Point3& x) {
  std::vector<double> distances;
  for (const Part& part : parts) {
    const auto& c = part.corners;
    distances.push_back(c.size() == 3
                            ? DistanceToTriangle(x, c[0], c[1], c[2])
                            : std::sqrt(geometry::SquaredDistance(x, c[0], c[c.size() - 1])));
  }
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool touch = std::ranges::any_of(
          parts[i].points, [&](FeatureId p) { return std::ranges::count(parts[j].points, p) > 0; });
      if (!touch) least = std::min(least, std::max(distances[i], distances[j]));
    }
  }
  return least;
}

// Triangles, segments and points far from each other or with common corners.
void ExpectAsAllPairs(int dimension, double tolerance) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    std::vector<Feature> features;
    std::vector<Part> parts;
    FeatureId next = 1;
    const auto point = [&](const Point3& p) {
      features.push_back(Feature::Point(next, p[0], p[1], p[2]));
      parts.push_back({{next}, {p}});
      return next++;
    };
    const auto segment = [&](FeatureId a, FeatureId b, const Point3& p, const Point3& q) {
      parts.push_back({{a, b}, {p, q}});
    };
    const int n = 1 + static_cast<int>(seed);
    for (int i = 0; i < n; ++i) {
      std::array<Point3, 3> p;
      std::array<FeatureId, 3> id;
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) p[j][k] = k < dimension ? any(random) + 3 * (i % 3) : 0;
      }
      for (int j = 0; j < 3; ++j) id[j] = point(p[j]);
      if (i % 3 == 1) {
        features.push_back(Feature::Segment(next++, id[0], id[1]));
        features.push_back(Feature::Segment(next++, id[0], id[2]));
        segment(id[0], id[1], p[0], p[1]);
        segment(id[0], id[2], p[0], p[2]);
      }
      if (i % 3 == 2) {
        features.push_back(Feature::Polygon(next++, {{id[0], id[1], id[2]}}));
        for (int j = 0; j < 3; ++j) segment(id[j], id[(j + 1) % 3], p[j], p[(j + 1) % 3]);
        if (dimension == 3) parts.push_back({{id[0], id[1], id[2]}, {p[0], p[1], p[2]}});
      }
    }
    std::shuffle(features.begin(), features.end(), random);
    const LocalFeatureSize size(features, dimension);
    for (int i = 0; i < 40; ++i) {
      Point3 x;
      for (int k = 0; k < 3; ++k) x[k] = k < dimension ? 10 * any(random) - 1 : 0;
      const double expected = NaiveAt(parts, x), found = size.At(x);
      ASSERT_LE(found, expected * (1 + 1e-12));
      ASSERT_GE(found, expected - tolerance);
    }
  }
}

TEST(LocalFeatureSize, IsThatOfAllPairs) { ExpectAsAllPairs(2, 1e-12); }
TEST(LocalFeatureSize, IsThatOfAllPairsIn3D) { ExpectAsAllPairs(3, 0.05); }

TEST(LocalFeatureSize, LeavesOutWhatNamesAbsentPoints) {
  const std::vector<Feature> features = {
      Feature::Point(1, 0, 0),          Feature::Point(2, 1, 0),   Feature::Segment(3, 1, 9),
      Feature::Polygon(4, {{1, 2, 9}}), Feature::Polygon(5, {{}}), Feature::Polygon(6, {})};
  const double points[] = {0, 0, 0, 0.25, 0, 0};
  EXPECT_EQ(LocalFeatureSizes(features, 3, points), (std::vector<double>{1, 0.75}));
}

TEST(LocalFeatureSize, IsInfiniteWithoutDisjointFeatures) {
  const Point3 x{{0.3, 0.3, 0}};
  EXPECT_EQ(LocalFeatureSize({}, 2).At(x), std::numeric_limits<double>::infinity());
  const std::vector<Feature> one = {Feature::Point(1, 0.5, 0.5)};
  EXPECT_EQ(LocalFeatureSize(one, 2).At(x), std::numeric_limits<double>::infinity());
  // The ends of a segment are disjoint.
  const std::vector<Feature> segment = {Feature::Point(1, 0, 0), Feature::Point(2, 1, 0),
                                        Feature::Segment(3, 1, 2)};
  EXPECT_DOUBLE_EQ(LocalFeatureSize(segment, 2).At({{0, 0, 0}}), 1);
  EXPECT_DOUBLE_EQ(LocalFeatureSize(segment, 2).At({{0.5, 0, 0}}), 0.5);
}

// All share the hub: no pair is disjoint but ends and other spokes.
TEST(LocalFeatureSize, OfAStarOfManySpokes) {
  std::vector<Feature> features = {Feature::Point(1, 0, 0)};
  constexpr int kSpokes = 1000;
  for (int i = 0; i < kSpokes; ++i) {
    const double angle = 2 * M_PI * i / kSpokes;
    const auto end = static_cast<FeatureId>(10 + 2 * i);
    features.push_back(Feature::Point(end, std::cos(angle), std::sin(angle)));
    features.push_back(Feature::Segment(end + 1, 1, end));
  }
  const LocalFeatureSize size(features, 2);
  EXPECT_NEAR(size.At({{0, 0, 0}}), 1, 1e-12);
  EXPECT_NEAR(size.At({{0.5, 0, 0}}), 0.5, 1e-3);
}

}  // namespace
}  // namespace dynmesh::quality
