#include "core/base/ring_walk.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <utility>

namespace dynmesh {
namespace {

using Ring = std::vector<int>;

// Walks edges that have a direction, the least end first.
struct Edges {
  std::map<int, std::multiset<int>> leaving;
  std::optional<int> operator()(int v) {
    std::multiset<int>& ends = leaving[v];
    if (ends.empty()) return std::nullopt;
    const int end = *ends.begin();
    ends.erase(ends.begin());
    return end;
  }
};

std::vector<Ring> Walk(int start, const std::vector<std::pair<int, int>>& directed) {
  Edges edges;
  for (const auto& [p, q] : directed) edges.leaving[p].insert(q);
  std::vector<Ring> rings;
  WalkRings(
      start, [&](int v) { return edges(v); }, rings);
  return rings;
}

TEST(WalkRings, AChainIsOneRing) {
  EXPECT_EQ(Walk(2, {{1, 2}, {2, 3}, {3, 1}}), (std::vector<Ring>{{2, 3, 1}}));
  EXPECT_TRUE(Walk(4, {{1, 2}, {2, 3}, {3, 1}}).empty());
}

TEST(WalkRings, WhereAWalkComesAgainARingIsCutOff) {
  // A square 1 4 5 6 with a triangle 4 2 3 at 4, and one at 1 after the walk came back.
  EXPECT_EQ(
      Walk(1, {{1, 4}, {4, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 1}, {1, 8}, {8, 9}, {9, 1}}),
      (std::vector<Ring>{{4, 2, 3}, {1, 4, 5, 6}, {1, 8, 9}}));
}

}  // namespace
}  // namespace dynmesh
