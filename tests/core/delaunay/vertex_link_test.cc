// The tables of a walk around a vertex against maps.
#include "core/delaunay/vertex_link.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <random>
#include <utility>

#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay::vertex_link_test {
namespace {

template <class Tables>
void CompareWithMaps(int most) {
  std::mt19937_64 bits(geometry::testing::NewSeed());
  Tables tables;
  for (int round = 0; round < 2000; ++round) {
    tables.Begin();
    std::map<std::uint32_t, int> numbers;
    std::map<std::pair<int, int>, int> edges;
    const int count = 1 + static_cast<int>(bits() % most);
    const std::uint32_t range = round % 2 == 0 ? 4 * count : ~std::uint32_t{0};
    while (static_cast<int>(numbers.size()) < count) {
      const auto u = static_cast<std::uint32_t>(bits() % range);
      const int next = static_cast<int>(numbers.size());
      const int number = numbers.try_emplace(u, next).first->second;
      ASSERT_EQ(tables.Number(u), number);
      ASSERT_EQ(tables.id(number), u);
    }
    ASSERT_FALSE(tables.IsTooSmall());
    ASSERT_EQ(tables.count(), count);
    for (int triangle = 0; triangle < 2 * count; ++triangle) {
      const std::pair edge(static_cast<int>(bits() % count), static_cast<int>(bits() % count));
      if (!edges.try_emplace(edge, triangle).second) continue;
      ASSERT_FALSE(tables.Has(edge.first, edge.second));
      tables.Set(edge.first, edge.second, triangle);
    }
    for (int a = 0; a < count; ++a) {
      for (int b = 0; b < count; ++b) {
        const auto it = edges.find({a, b});
        ASSERT_EQ(tables.Has(a, b), it != edges.end());
        if (it == edges.end()) continue;
        ASSERT_EQ(tables.TriangleAt(a, b), it->second);
      }
    }
  }
}

TEST(LinkTables, AreMaps) {
  CompareWithMaps<SmallLinkTables>(SmallLinkTables::kMost);
  CompareWithMaps<LargeLinkTables>(150);
}

TEST(LinkTables, SayWhenTheyAreTooSmall) {
  SmallLinkTables tables;
  tables.Begin();
  for (int i = 0; i < SmallLinkTables::kMost; ++i) tables.Number(static_cast<std::uint32_t>(7 * i));
  EXPECT_FALSE(tables.IsTooSmall());
  tables.Number(7);
  EXPECT_FALSE(tables.IsTooSmall());
  tables.Number(8);
  EXPECT_TRUE(tables.IsTooSmall());
  tables.Begin();
  EXPECT_FALSE(tables.IsTooSmall());
}

TEST(LinkTables, ForgetWhenStampsComeRound) {
  SmallLinkTables tables;
  tables.Begin();
  tables.Set(1, 2, 3);
  for (int i = 0; i < (1 << 24) + 2; ++i) {
    tables.Begin();
    if (tables.Has(1, 2)) FAIL() << "after " << i;
  }
}

}  // namespace
}  // namespace dynmesh::delaunay::vertex_link_test
