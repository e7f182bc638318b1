// Keys get numbers in the order in which they come, as a map would give them.
#include "core/delaunay/number_table.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>

#include "tests/core/geometry/random_points.h"

namespace dynmesh::delaunay::number_table_test {
namespace {

TEST(NumberTable, NumbersLikeAMapWhateverCameBefore) {
  const std::uint64_t seed = geometry::testing::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  NumberTable<2> table;
  for (const std::uint32_t range : {2u, 1000u, 7u, 50u, 3u, 300u}) {
    table.Clear();
    EXPECT_TRUE(table.keys().empty());
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> expected;
    for (int i = 0; i < 3000; ++i) {
      const std::array<std::uint32_t, 2> key = {static_cast<std::uint32_t>(random() % range),
                                                ~static_cast<std::uint32_t>(random() % 5)};
      const auto known = expected.find(key);
      ASSERT_EQ(table.Find(key), known == expected.end() ? NumberTable<2>::kNone : known->second);
      if (random() % 2 == 0) continue;
      const auto next = static_cast<std::uint32_t>(expected.size());
      ASSERT_EQ(table.Number(key), expected.try_emplace(key, next).first->second);
      ASSERT_EQ(table.keys()[expected[key]], key);
    }
    ASSERT_EQ(table.keys().size(), expected.size());
  }
}

}  // namespace
}  // namespace dynmesh::delaunay::number_table_test
