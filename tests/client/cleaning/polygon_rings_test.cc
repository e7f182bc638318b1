#include "client/cleaning/polygon_rings.h"

#include "gtest/gtest.h"

namespace dynmesh::cleaning::polygon_rings_test {
namespace {

using Edges = std::vector<NodePair>;
using NodeRings = std::vector<NodeRing>;

TEST(PolygonRings, RingsWhoseEdgesAreAllThereStayAsTheyAre) {
  const NodeRings were = {{5, 3, 4}, {2, 0, 1}};
  const RemadeRings remade = RemakeRings(were, {{0, 1}, {0, 2}, {1, 2}, {3, 4}, {3, 5}, {4, 5}});
  EXPECT_EQ(remade.rings, were);
  EXPECT_TRUE(remade.cuts.empty());
}

TEST(PolygonRings, ASplitEdgeIsTheChainOfItsParts) {
  // 0-1 goes through 7 now; the other ring is unchanged.
  const RemadeRings remade =
      RemakeRings({{0, 1, 2}, {5, 3, 4}}, {{0, 2}, {0, 7}, {1, 2}, {1, 7}, {3, 4}, {3, 5}, {4, 5}});
  EXPECT_EQ(remade.rings, (NodeRings{{0, 2, 1, 7}, {5, 3, 4}}));
  EXPECT_TRUE(remade.cuts.empty());
}

TEST(PolygonRings, ARingThatComesToAPlaceTwiceIsCutThere) {
  const RemadeRings remade =
      RemakeRings({{0, 1, 2, 3, 4, 2}}, {{0, 1}, {0, 2}, {1, 2}, {2, 3}, {2, 4}, {3, 4}});
  EXPECT_EQ(remade.rings, (NodeRings{{0, 1, 2}, {2, 3, 4}}));
  EXPECT_EQ(remade.cuts, (NodeRing{2}));
}

TEST(PolygonRings, WithoutEdgesThereAreNoRings) {
  EXPECT_TRUE(RemakeRings({{0, 1, 2}}, {}).rings.empty());
  EXPECT_TRUE(RemakeRings({}, {}).rings.empty());
  EXPECT_TRUE(RemakeRings({{}}, {}).rings.empty());
}

TEST(PolygonRings, ARingThatStandsThriceIsThereOnce) {
  const RemadeRings remade =
      RemakeRings({{0, 1, 2}, {1, 2, 0}, {0, 2, 1}}, {{0, 1}, {0, 2}, {1, 2}});
  EXPECT_EQ(remade.rings, (NodeRings{{0, 1, 2}}));
}

}  // namespace
}  // namespace dynmesh::cleaning::polygon_rings_test
