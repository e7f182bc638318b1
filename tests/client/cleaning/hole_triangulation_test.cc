#include "client/cleaning/hole_triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <iterator>
#include <limits>
#include <set>
#include <vector>

#include "tests/client/cleaning/surface_soups.h"

namespace dynmesh::cleaning::hole_triangulation_test {
namespace {

constexpr std::uint64_t kSeed = 5;

// By trying all.
double BestOf(const std::vector<Point3>& chain) {
  if (chain.size() < 3) return 0;
  double best = 1e300;
  for (std::size_t k = 1; k + 1 < chain.size(); ++k) {
    const auto middle = chain.begin() + static_cast<std::ptrdiff_t>(k);
    best = std::min(best,
                    std::max({LargestCotangent({chain[0], chain[k], chain.back()}),
                              BestOf({chain.begin(), middle + 1}), BestOf({middle, chain.end()})}));
  }
  return best;
}

TEST(HoleTriangulation, NoneHasALargerLeastAngle) {
  std::cout << "seed " << kSeed << "\n";
  SoupMaker maker(kSeed);
  for (int i = 0; i < 200; ++i) {
    std::vector<Point3> chain;
    const int n = maker.Integer(3, 8);
    for (int k = 0; k < n; ++k) chain.push_back(maker.Place(0, 1));
    const auto triangles = TriangulateHole(chain);
    ASSERT_EQ(triangles.size(), chain.size() - 2);
    double most = 0;
    std::size_t sides = 0;
    for (const auto& t : triangles) {
      EXPECT_TRUE(t[0] < t[1] && t[1] < t[2]);
      most = std::max(most, LargestCotangent({chain[t[0]], chain[t[1]], chain[t[2]]}));
      sides += (t[1] == t[0] + 1 ? 1U : 0U) + (t[2] == t[1] + 1 ? 1U : 0U) +
               (t[0] == 0 && t[2] + 1 == chain.size() ? 1U : 0U);
    }
    EXPECT_EQ(sides, chain.size());
    EXPECT_EQ(most, BestOf(chain)) << i;
  }
}

// Twice as large.
double AreaOf(const Point3& a, const Point3& b, const Point3& c) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double part = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
    sum += part * part;
  }
  return std::sqrt(sum);
}

// By trying all: the least area of those without the forbidden triangles; infinite if there are
// none. `first`: the index of the chain's first node.
double LeastArea(const std::vector<Point3>& chain,
                 const std::vector<std::array<std::size_t, 3>>& forbidden, std::size_t first = 0) {
  if (chain.size() < 3) return 0;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k + 1 < chain.size(); ++k) {
    const std::array<std::size_t, 3> triple = {first, first + k, first + chain.size() - 1};
    if (std::ranges::find(forbidden, triple) != forbidden.end()) continue;
    const auto middle = chain.begin() + static_cast<std::ptrdiff_t>(k);
    best = std::min(best, AreaOf(chain[0], chain[k], chain.back()) +
                              LeastArea({chain.begin(), middle + 1}, forbidden, first) +
                              LeastArea({middle, chain.end()}, forbidden, first + k));
  }
  return best;
}

TEST(HoleTriangulation, NoneWithoutForbiddenTrianglesHasALesserArea) {
  std::cout << "seed " << kSeed << "\n";
  SoupMaker maker(kSeed);
  int impossible = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<Point3> chain;
    const int n = maker.Integer(3, 7);
    for (int k = 0; k < n; ++k) chain.push_back(maker.Place(0, 1));
    std::vector<std::array<std::size_t, 3>> forbidden;
    for (int k = maker.Integer(0, 8); k > 0; --k) {
      std::set<std::size_t> triple;
      while (triple.size() < 3) triple.insert(static_cast<std::size_t>(maker.Integer(0, n - 1)));
      std::copy(triple.begin(), triple.end(), forbidden.emplace_back().begin());
    }
    const auto triangles = TriangulateHole(chain, HoleMeasure::kArea, forbidden);
    const double least = LeastArea(chain, forbidden);
    if (triangles.empty()) {
      EXPECT_TRUE(std::isinf(least)) << i;
      ++impossible;
      continue;
    }
    EXPECT_EQ(triangles.size(), chain.size() - 2);
    double area = 0;
    for (const auto& t : triangles) {
      EXPECT_EQ(std::ranges::find(forbidden, t), forbidden.end()) << i;
      area += AreaOf(chain[t[0]], chain[t[1]], chain[t[2]]);
    }
    EXPECT_NEAR(area, least, 1e-12) << i;
  }
  EXPECT_GT(impossible, 10);
}

}  // namespace
}  // namespace dynmesh::cleaning::hole_triangulation_test
