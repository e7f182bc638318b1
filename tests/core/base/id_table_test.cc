#include "core/base/id_table.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "core/base/mix.h"

namespace dynmesh {
namespace {

using Numbers = std::vector<IdTable::Number>;

TEST(IdTable, FindsAllAndNothingElse) {
  for (const std::uint64_t n : {0, 1, 2, 3, 31, 32, 33, 1000, 5000}) {
    std::vector<std::uint64_t> ids;
    for (std::uint64_t i = 0; i < n; ++i) ids.push_back(Mix(i));
    const IdTable table(ids);
    EXPECT_FALSE(table.repeated());
    Numbers found(n);
    table.FindAll(ids, found);
    for (std::uint64_t i = 0; i < n; ++i) {
      EXPECT_EQ(found[i], i);
      EXPECT_EQ(table.Find(ids[i]), i);
    }
    for (std::uint64_t i = n; i < 2 * n + 5; ++i) EXPECT_EQ(table.Find(Mix(i)), IdTable::kNone);
  }
}

TEST(IdTable, SmallAndNeighbouringIdsAreIdsToo) {
  std::vector<std::uint64_t> ids;
  for (std::uint64_t i = 0; i < 3000; ++i) ids.push_back(i);
  for (std::uint64_t i = 1; i < 3000; ++i) ids.push_back(i << 48);
  ids.push_back(~std::uint64_t{0});
  const IdTable table(ids, [](std::size_t i) { return static_cast<IdTable::Number>(7 * i); });
  for (std::size_t i = 0; i < ids.size(); ++i) EXPECT_EQ(table.Find(ids[i]), 7 * i);
  EXPECT_EQ(table.Find(3001), IdTable::kNone);
}

TEST(IdTable, OfEqualIdsTheFirstCounts) {
  const std::vector<std::uint64_t> ids = {5, 6, 7, 6, 5};
  const IdTable table(ids);
  ASSERT_TRUE(table.repeated());
  EXPECT_EQ(*table.repeated(), 3U);
  Numbers found(5);
  table.FindAll(ids, found);
  EXPECT_EQ(found, Numbers({0, 1, 2, 1, 0}));
}

}  // namespace
}  // namespace dynmesh
