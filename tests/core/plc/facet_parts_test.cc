// Whether the inside of a facet is connected, against flooding the squares of a grid; its border is
// cut into rings at random.
#include "core/plc/facet_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::plc::facet_parts_test {
namespace {

constexpr int kSide = 6;
using Cells = std::set<std::pair<int, int>>;
using Node = std::pair<int, int>;

// Closed chains that visit no point twice.
using Chains = std::vector<std::vector<Node>>;

// Rings of all edges between cells in the set and others: walks that are cut where they meet
// themselves.
Chains CutBorder(const Cells& cells, test::Random& random) {
  std::map<Node, std::vector<Node>> beside;
  const auto join = [&](Node a, Node b) {
    beside[a].push_back(b);
    beside[b].push_back(a);
  };
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      const bool here = cells.contains({i, j});
      if (here != cells.contains({i - 1, j})) join({i, j}, {i, j + 1});
      if (here != cells.contains({i, j - 1})) join({i, j}, {i + 1, j});
    }
  }
  Chains chains;
  for (const auto& [start, unused] : beside) {
    std::vector<Node> walk = {start};
    while (!beside[start].empty() || walk.size() > 1) {
      auto& ways = beside[walk.back()];
      const std::size_t k = static_cast<std::size_t>(random.Below(static_cast<int>(ways.size())));
      const Node to = ways[k], from = walk.back();
      ways.erase(ways.begin() + static_cast<std::ptrdiff_t>(k));
      auto& back = beside[to];
      back.erase(std::find(back.begin(), back.end(), from));
      const auto at = std::find(walk.begin(), walk.end(), to);
      if (at == walk.end()) {
        walk.push_back(to);
        continue;
      }
      chains.emplace_back(at, walk.end());
      walk.erase(at + 1, walk.end());
    }
  }
  return chains;
}

bool HangsTogether(Cells cells) {
  std::vector<std::pair<int, int>> ahead = {*cells.begin()};
  cells.erase(cells.begin());
  while (!ahead.empty()) {
    const auto [i, j] = ahead.back();
    ahead.pop_back();
    for (const auto& next :
         std::array<std::pair<int, int>, 4>{{{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}}}) {
      if (cells.erase(next) > 0) ahead.push_back(next);
    }
  }
  return cells.empty();
}

// In a plane that is along no axis, a skewed grid.
Facet FacetOf(const Chains& chains) {
  FacetFeature feature{1, {}, {}};
  for (const auto& chain : chains) {
    auto& ring = feature.rings.emplace_back();
    auto& places = feature.positions.emplace_back();
    for (const auto& [i, j] : chain) {
      ring.push_back(static_cast<FeatureId>(1 + i + (kSide + 1) * j));
      places.push_back({{0.8 * i + 0.1 * j, 0.6 * j - 0.1 * i, 0.5 * i + 0.3 * j}});
    }
  }
  return Facet(feature);
}

TEST(FacetParts, AreWhatFloodingFinds) {
  int apart = 0, together = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    Cells cells;
    const int most = 1 + random.Below(kSide * kSide);
    // Grown from one cell, so that many are connected; some scattered.
    cells.emplace(random.Below(kSide), random.Below(kSide));
    const bool scattered = random.OneIn(3);
    for (int n = 0; n < most; ++n) {
      std::pair<int, int> cell = {random.Below(kSide), random.Below(kSide)};
      const bool touches = cells.contains({cell.first - 1, cell.second}) ||
                           cells.contains({cell.first + 1, cell.second}) ||
                           cells.contains({cell.first, cell.second - 1}) ||
                           cells.contains({cell.first, cell.second + 1});
      if (touches || scattered) cells.insert(cell);
    }
    const bool wanted = !HangsTogether(cells);
    ++(wanted ? apart : together);
    ASSERT_EQ(FallsApart(FacetOf(CutBorder(cells, random))), wanted);
  }
  EXPECT_GT(apart, 200);
  EXPECT_GT(together, 200);
}

TEST(FacetParts, OneRingIsOnePart) {
  EXPECT_FALSE(FallsApart(FacetOf({{{0, 0}, {2, 0}, {2, 2}, {0, 2}}})));
}

}  // namespace
}  // namespace dynmesh::plc::facet_parts_test
