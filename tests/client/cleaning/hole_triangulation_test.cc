#include "client/cleaning/hole_triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
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

}  // namespace
}  // namespace dynmesh::cleaning::hole_triangulation_test
