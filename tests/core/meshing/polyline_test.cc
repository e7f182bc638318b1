#include "core/meshing/polyline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/rounding.h"
#include "core/meshing/sizing_field.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::polyline_test {
namespace {

using geometry::Point;

constexpr std::uint64_t kSeed = 20261125;

// In long double, by ternary search along the edge: no formula in common with the product.
template <int D>
double NaiveDistance(const Point<D>& x, const Point<D>& a, const Point<D>& b) {
  const auto at = [&](long double t) {
    long double sum = 0;
    for (int k = 0; k < D; ++k) {
      const long double d = a[k] + t * (static_cast<long double>(b[k]) - a[k]) - x[k];
      sum += d * d;
    }
    return std::sqrt(sum);
  };
  long double lo = 0, hi = 1;
  for (int i = 0; i < 120; ++i) {
    const long double s = lo + (hi - lo) / 3, t = hi - (hi - lo) / 3;
    (at(s) < at(t) ? hi : lo) = at(s) < at(t) ? t : s;
  }
  return static_cast<double>(std::min({at(lo), at(0), at(1)}));
}

template <int D>
Point<D> AnyPoint(test::Random& random) {
  Point<D> p;
  for (int k = 0; k < D; ++k) p[k] = 3 * random.Unit() - 1;
  return p;
}

// With edges of length 0, in one line, there and back, and closed ones among them.
template <int D>
std::vector<Point<D>> RandomPath(test::Random& random) {
  std::vector<Point<D>> path = {AnyPoint<D>(random)};
  const int edges = 1 + random.Below(random.OneIn(3) ? 200 : 6);
  for (int i = 0; i < edges; ++i) {
    Point<D> next = path.back();
    const int kind = random.Below(6);
    if (kind == 1 && path.size() > 1) next = path[path.size() - 2];
    if (kind == 2) next[random.Below(D)] += std::ldexp(random.Unit() - 0.5, -random.Below(8));
    if (kind == 3 && path.size() > 1) {
      for (int k = 0; k < D; ++k) next[k] += path.back()[k] - path[path.size() - 2][k];
    }
    if (kind > 3) {
      for (int k = 0; k < D; ++k) next[k] += 0.4 * (random.Unit() - 0.5);
    }
    path.push_back(next);
  }
  if (random.OneIn(3)) path.push_back(path.front());
  return path;
}

template <int D>
void ExpectTheDistanceOfTheNearestEdge() {
  int met = 0, asked = 0;
  for (std::uint64_t seed = kSeed; seed < kSeed + 60; ++seed) {
    test::Random random(seed);
    const std::vector<Point<D>> path = RandomPath<D>(random);
    const Polyline<D> polyline(path);
    for (int i = 0; i < 100; ++i) {
      Point<D> x = AnyPoint<D>(random);
      if (random.OneIn(4))
        x = path[static_cast<std::size_t>(random.Below(static_cast<int>(path.size())))];
      const double radius = random.OneIn(8) ? 0 : std::ldexp(random.Unit(), -random.Below(8));
      double nearest = INFINITY;
      bool exact = false;  // the same edges, one by one, to the bit
      for (std::size_t k = 0; k + 1 < path.size(); ++k) {
        const Point<D>&a = std::min(path[k], path[k + 1]), &b = std::max(path[k], path[k + 1]);
        nearest = std::min(nearest, NaiveDistance<D>(x, a, b));
        exact |= SquaredDistanceToEdge<D>(x, a, b) <= radius * radius;
      }
      const bool meets = polyline.Meets(x, radius);
      ASSERT_EQ(meets, exact) << "seed " << seed << ", query " << i;
      met += meets ? 1 : 0, ++asked;
      if (std::fabs(nearest - radius) < 1e-9) continue;
      ASSERT_EQ(meets, nearest < radius) << "seed " << seed << ", query " << i;
    }
  }
  EXPECT_GT(met, asked / 5);
  EXPECT_LT(met, asked * 4 / 5);
}

TEST(Polyline, MeetsWhatALookAtEveryEdgeSays) { ExpectTheDistanceOfTheNearestEdge<2>(); }
TEST(Polyline, MeetsWhatALookAtEveryEdgeSaysIn3D) { ExpectTheDistanceOfTheNearestEdge<3>(); }

template <int D>
void ExpectNoDependenceOnTheDirection() {
  for (std::uint64_t seed = kSeed; seed < kSeed + 20; ++seed) {
    test::Random random(seed);
    std::vector<Point<D>> path = RandomPath<D>(random);
    const Polyline<D> one(path);
    std::reverse(path.begin(), path.end());
    const Polyline<D> other(path);
    path.push_back(path[path.size() - 2]);  // a edge twice
    const Polyline<D> doubled(path);
    for (int i = 0; i < 500; ++i) {
      // At the distance of a edge: there rounding decides.
      const Point<D> x = AnyPoint<D>(random);
      const auto k = static_cast<std::size_t>(random.Below(static_cast<int>(path.size()) - 1));
      const double radius = std::sqrt(SquaredDistanceToEdge<D>(x, std::min(path[k], path[k + 1]),
                                                               std::max(path[k], path[k + 1])));
      ASSERT_EQ(one.Meets(x, radius), other.Meets(x, radius)) << "seed " << seed;
      ASSERT_EQ(one.Meets(x, radius), doubled.Meets(x, radius)) << "seed " << seed;
    }
  }
}

TEST(Polyline, DoesNotDependOnItsDirection) {
  ExpectNoDependenceOnTheDirection<2>();
  ExpectNoDependenceOnTheDirection<3>();
}

// Far from the origin the foot of a perpendicular rounds by more than the distance is small.
TEST(Polyline, ABoxAroundAnEdgeIsNeverFartherThanTheEdge) {
  test::Random random(kSeed);
  for (int i = 0; i < 100'000; ++i) {
    Point<2> a, b, x;
    for (int k = 0; k < 2; ++k) {
      a[k] = 1e6 + std::ldexp(random.Unit(), -random.Below(30));
      b[k] = random.OneIn(3) ? a[k] : a[k] + std::ldexp(random.Unit(), -random.Below(30));
      x[k] = a[k] + std::ldexp(random.Unit() - 0.5, -random.Below(30));
    }
    if (b < a) std::swap(a, b);
    double d2 = 0;
    for (int k = 0; k < 2; ++k) {
      const double d = std::max({std::min(a[k], b[k]) - x[k], x[k] - std::max(a[k], b[k]), 0.0});
      d2 += d * d;
    }
    ASSERT_LE(d2, SquaredDistanceToEdge<2>(x, a, b)) << i;
  }
}

// Notifications leave room for 16 ulps of the largest coordinate.
template <int D>
double MostErrorInUlps() {
  test::Random random(kSeed);
  double most = 0;
  for (int i = 0; i < 20'000; ++i) {
    Point<D> a, b, x;
    double largest = 0;
    for (int k = 0; k < D; ++k) {
      a[k] = std::ldexp(random.Unit() - 0.5, 1 - random.Below(4));
      b[k] = random.OneIn(4) ? a[k] : random.Unit() - 0.5;
      x[k] = random.OneIn(2) ? a[k] + random.Unit() * (b[k] - a[k]) : 2 * random.Unit() - 1;
      x[k] += std::ldexp(random.Unit() - 0.5, -random.Below(52));
      largest = std::max({largest, std::fabs(a[k]), std::fabs(b[k]), std::fabs(x[k])});
    }
    if (b < a) std::swap(a, b);
    const double error = std::sqrt(SquaredDistanceToEdge<D>(x, a, b)) - NaiveDistance<D>(x, a, b);
    most = std::max(most, std::fabs(error) / UlpOf(largest));
  }
  return most;
}

TEST(Polyline, ItsDistancesAreOffByAFewUlps) {
  EXPECT_LE(MostErrorInUlps<2>(), 4);
  EXPECT_LE(MostErrorInUlps<3>(), 4);
}

TEST(Polyline, WithARadiusIsACapsule) {
  const std::vector<Point<2>> path = {{{0, 0}}, {{4, 0}}, {{4, 4}}};
  const auto polyline = std::make_shared<const Polyline<2>>(path);
  const SizingRegion<2> capsule{polyline->lo(), polyline->hi(), 1, 0.5, polyline};
  EXPECT_TRUE(capsule.Meets({{2, 1}}, 0));
  EXPECT_FALSE(capsule.Meets({{2, 1.01}}, 0));
  EXPECT_TRUE(capsule.Meets({{2, 1.5}}, 0.5));
  EXPECT_FALSE(capsule.Meets({{1, 3}}, 1.9));  // in the box around it
  EXPECT_TRUE(capsule.Meets({{1, 3}}, 2));
  EXPECT_TRUE(capsule.Meets({{-3, -4}}, 4));
}

}  // namespace
}  // namespace dynmesh::meshing::polyline_test
