#include "core/io/solvers/edge_chains.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "gtest/gtest.h"
#include "tests/support/seed.h"

namespace dynmesh::io::edge_chains_test {
namespace {

TEST(EdgeChains, AChainHasTheDirectionOfItsEdges) {
  EXPECT_EQ(ChainsOf({{2, 3}, {1, 2}, {3, 4}}), (std::vector<Chain>{{1, 2, 3, 4}}));
  // Edges that are directed either way: from the end that comes first.
  EXPECT_EQ(ChainsOf({{2, 1}, {2, 3}}), (std::vector<Chain>{{1, 2, 3}}));
}

TEST(EdgeChains, AClosedOneEndsWhereItBegins) {
  EXPECT_EQ(ChainsOf({{5, 6}, {4, 5}, {6, 4}}), (std::vector<Chain>{{5, 6, 4, 5}}));
}

TEST(EdgeChains, BranchesAreEnds) {
  EXPECT_EQ(ChainsOf({{1, 2}, {2, 3}, {4, 2}}), (std::vector<Chain>{{1, 2}, {2, 3}, {4, 2}}));
  // Two loops that touch.
  EXPECT_EQ(ChainsOf({{0, 1}, {1, 2}, {2, 0}, {0, 3}, {3, 4}, {4, 0}}),
            (std::vector<Chain>{{0, 1, 2, 0}, {0, 3, 4, 0}}));
}

TEST(EdgeChains, NoEdgesAreNoChains) { EXPECT_TRUE(ChainsOf({}).empty()); }

// Of any graph: each edge is in one chain once, chains end at ends, and there are as few as can be.
TEST(EdgeChains, OfAnyGraph) {
  std::mt19937_64 random(test::NewSeed());
  for (int round = 0; round < 300; ++round) {
    const std::uint32_t vertices = 2 + random() % 12;
    std::set<std::set<std::uint32_t>> graph;
    std::vector<DirectedEdge> edges;
    for (std::uint64_t i = random() % 20; i > 0; --i) {
      const auto a = static_cast<std::uint32_t>(random() % vertices);
      const auto b = static_cast<std::uint32_t>(random() % vertices);
      if (a != b && graph.insert({a, b}).second) edges.emplace_back(a, b);
    }
    std::map<std::uint32_t, int> degree;
    for (const auto& [a, b] : edges) ++degree[a], ++degree[b];
    std::map<std::uint32_t, int> ends;
    std::set<std::set<std::uint32_t>> covered;
    for (const Chain& chain : ChainsOf(edges)) {
      ASSERT_GE(chain.size(), 2u);
      for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
        EXPECT_TRUE(covered.insert({chain[i], chain[i + 1]}).second);
        if (i != 0) {
          EXPECT_EQ(degree[chain[i]], 2);
        }
      }
      ++ends[chain.front()], ++ends[chain.back()];
    }
    EXPECT_EQ(covered, graph);
    for (const auto& [v, d] : degree) {
      if (d != 2) {
        EXPECT_EQ(ends[v], d);
      } else {
        EXPECT_TRUE(ends[v] == 0 || ends[v] == 2) << v;
      }
    }
  }
}

}  // namespace
}  // namespace dynmesh::io::edge_chains_test
