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

TEST(NodeTable, ALevelHasAWiderTolerance) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  NodeTable3 nodes(0.01, 4);
  for (int i = 0; i < 2000; ++i) {
    const Point3 p = {coordinate(random), coordinate(random), coordinate(random)};
    const int level = i % 5;
    const double tolerance = 0.01 * (1 << level);
    std::optional<Node> expected;
    for (Node v = 0; v < nodes.size(); ++v) {
      const double distance = SquaredDistance<3>(p, nodes.at(v));
      if (distance >= tolerance * tolerance) continue;
      if (!expected || distance < SquaredDistance<3>(p, nodes.at(*expected))) expected = v;
    }
    ASSERT_EQ(nodes.Near(p, level), expected);
    if (!expected) nodes.Add(p);
  }
}

}  // namespace
}  // namespace dynmesh::cleaning::node_table_test
