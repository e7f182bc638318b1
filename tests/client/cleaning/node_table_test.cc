#include "client/cleaning/node_table.h"

#include <random>

#include "gtest/gtest.h"

namespace dynmesh::cleaning::node_table_test {
namespace {

TEST(NodeTable, NearAgreesWithLookingAtAll) {
  constexpr double kTolerance = 0.02;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  NodeTable nodes(kTolerance);
  for (int i = 0; i < 5000; ++i) {
    const Point p = {coordinate(random), coordinate(random)};
    std::optional<Node> expected;
    for (Node v = 0; v < nodes.size(); ++v) {
      const double distance = SquaredDistance<2>(p, nodes.at(v));
      if (distance >= kTolerance * kTolerance) continue;
      if (!expected || distance < SquaredDistance<2>(p, nodes.at(*expected))) expected = v;
    }
    const std::optional<Node> near = nodes.Near(p);
    // Exactly at the tolerance it may count as either.
    ASSERT_EQ(near, expected) << p[0] << " " << p[1];
    if (!near) nodes.Add(p);
  }
  EXPECT_GT(nodes.size(), 1000U);
}

}  // namespace
}  // namespace dynmesh::cleaning::node_table_test
