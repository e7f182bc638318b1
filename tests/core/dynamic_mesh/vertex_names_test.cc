#include "core/dynamic_mesh/vertex_names.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::vertex_names_test {
namespace {

using geometry::Point2;
using Index = VertexNames<2>::Index;

// Seven names; with salt, one more for each.
VertexId SevenNames(const double* c, int, std::uint64_t salt) {
  return 1 + static_cast<VertexId>(c[0]) % 7 + 7 * salt;
}

// By definition: within each name, in the order of coordinates.
std::map<Index, VertexId> NamesByDefinition(const std::map<Index, Point2>& present) {
  std::map<VertexId, std::vector<std::pair<Point2, Index>>> groups;
  for (const auto& [v, p] : present) groups[SevenNames(p.c.data(), 2, 0)].push_back({p, v});
  std::map<Index, VertexId> names;
  for (auto& [name, members] : groups) {
    std::sort(members.begin(), members.end());
    for (std::size_t salt = 0; salt < members.size(); ++salt) {
      names[members[salt].second] = SevenNames(members[salt].first.c.data(), 2, salt);
    }
  }
  return names;
}

TEST(VertexNames, AreAFunctionOfThePointsPresentAndChangesAreTold) {
  const std::uint64_t seed = 5;
  SCOPED_TRACE("seed " + std::to_string(seed));
  test::Random random(seed);
  VertexNames<2> names(&SevenNames);
  std::vector<Point2> place(60);
  for (Index v = 0; v < place.size(); ++v) {
    place[v] = {{static_cast<double>(random.Below(40)), static_cast<double>(v)}};
  }
  const auto position = [&](Index v) -> const Point2& { return place[v]; };
  std::map<Index, Point2> present;
  std::map<Index, VertexId> known;  // kept by what is told alone
  int told = 0;
  for (int step = 0; step < 3000; ++step) {
    const Index v = static_cast<Index>(random.Below(static_cast<int>(place.size())));
    std::vector<Index> renamed;
    const auto tell = [&](Index w) {
      ASSERT_NE(w, v);
      ASSERT_EQ(names.at(w), known.at(w)) << "told too late";
      renamed.push_back(w);
    };
    if (present.erase(v) > 0) {
      const VertexId former = names.at(v);
      names.Remove(v, position, tell);
      EXPECT_EQ(names.at(v), former) << "stays readable";
      known.erase(v);
    } else {
      names.Add(v, position, tell);
      present[v] = place[v];
      known[v] = names.at(v);
    }
    for (const Index w : renamed) known[w] = names.at(w);
    told += static_cast<int>(renamed.size());
    ASSERT_EQ(known, NamesByDefinition(present)) << "step " << step;
  }
  EXPECT_GT(told, 1000);
}

TEST(VertexNames, WithoutCollisionsAreTheHashAlone) {
  VertexNames<2> names;
  const std::vector<Point2> place = {{{0, 0}}, {{0, 1}}, {{0.5, 0.25}}};
  const auto position = [&](Index v) -> const Point2& { return place[v]; };
  for (Index v = 0; v < place.size(); ++v) names.Add(v, position, [](Index) { FAIL(); });
  for (Index v = 0; v < place.size(); ++v) {
    EXPECT_EQ(names.at(v), VertexIdAt(place[v].c.data(), 2));
  }
}

}  // namespace
}  // namespace dynmesh::vertex_names_test
