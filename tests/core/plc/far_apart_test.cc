// The certificate against comparing all pairs.
#include "core/plc/far_apart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/core/geometry/random_points.h"

namespace dynmesh::plc::far_apart_test {
namespace {

template <int D>
double LeastDistance(const std::vector<PointFeature<D>>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      least = std::min(least, geometry::SquaredDistance(points[i].p, points[j].p));
    }
  }
  return std::sqrt(least);
}

// Random points in a random box, some in pairs near to each other.
template <int D>
void CompareWithAllPairs() {
  std::mt19937_64 bits(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> unit(0, 1);
  int far = 0, near = 0;
  for (int round = 0; round < 3000; ++round) {
    Box box;
    for (int k = 0; k < D; ++k) {
      box.lo[k] = 10 * unit(bits) - 5;
      box.hi[k] = box.lo[k] + (round % 7 == k ? 0 : std::ldexp(unit(bits), -(round % 5)));
    }
    const int count = 1 + static_cast<int>(bits() % 200);
    std::vector<PointFeature<D>> points;
    const double pair = std::pow(10, -6 * unit(bits));
    for (int i = 0; i < count; ++i) {
      PointFeature<D> f{static_cast<FeatureId>(i + 1), {}};
      const bool is_pair = i > 0 && bits() % 64 == 0;
      for (int k = 0; k < D; ++k) {
        const double x = is_pair ? points.back().p[k] + pair * (unit(bits) - 0.5)
                                 : box.lo[k] + unit(bits) * (box.hi[k] - box.lo[k]);
        f.p[k] = std::clamp(x, box.lo[k], box.hi[k]);
      }
      points.push_back(f);
    }
    std::shuffle(points.begin(), points.end(), bits);
    const double least = LeastDistance<D>(points);
    const double limit =
        std::isfinite(least) ? std::max(least * (0.5 + 0.6 * unit(bits)), 1e-9) : 0.001;
    AllSteps all;
    const bool are_far = AreFarApart<D>(points, box, limit, all);
    if (least <= limit) {
      EXPECT_FALSE(are_far) << "round " << round << ": " << least << " of " << limit;
      ++near;
    } else {
      far += are_far ? 1 : 0;
    }
  }
  EXPECT_GT(near, 300);
  EXPECT_GT(far, 300);
}

TEST(AreFarApart, NeverTrueOfPointsThatAreNot) {
  CompareWithAllPairs<2>();
  CompareWithAllPairs<3>();
}

// Usual input gets its certificate.
template <int D>
void IsTrueOfUniformPoints() {
  std::mt19937_64 bits(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<PointFeature<D>> points(20000);
  for (PointFeature<D>& f : points) {
    for (int k = 0; k < D; ++k) f.p[k] = unit(bits);
  }
  AllSteps all;
  EXPECT_TRUE(AreFarApart<D>(points, {}, 1e-12, all));
}

TEST(AreFarApart, IsTrueOfUniformPoints) {
  IsTrueOfUniformPoints<2>();
  IsTrueOfUniformPoints<3>();
}

}  // namespace
}  // namespace dynmesh::plc::far_apart_test
