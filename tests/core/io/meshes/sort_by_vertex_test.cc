#include "core/io/meshes/sort_by_vertex.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::io {
namespace {

using Row = std::array<std::uint32_t, 3>;

TEST(SortByVertex, IsSort) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const int vertices = 1 + random.Below(random.OneIn(3) ? 4 : 500);
    const int used = 1 + random.Below(vertices);  // the others begin no row
    std::vector<Row> rows(static_cast<std::size_t>(random.Below(600)));
    for (Row& row : rows) {
      row = {static_cast<std::uint32_t>(random.Below(used)),
             static_cast<std::uint32_t>(random.Below(9)),
             static_cast<std::uint32_t>(random.Below(3))};
    }
    std::vector<Row> wanted = rows;
    std::sort(wanted.begin(), wanted.end());
    SortByVertex(
        rows, static_cast<std::size_t>(vertices), [](const Row& row) { return row[0]; },
        std::less<>());
    ASSERT_EQ(rows, wanted);
  }
}

TEST(SortByVertex, TakesNothing) {
  std::vector<Row> rows;
  SortByVertex(
      rows, 0, [](const Row& row) { return row[0]; }, std::less<>());
  EXPECT_TRUE(rows.empty());
}

}  // namespace
}  // namespace dynmesh::io
