// Closed surfaces of random sets of polygons, against the definition taken literally.
#include "core/dynamic_mesh/surface_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh {
namespace {

using plc::EdgeKey;
using plc::FacetFeature;
using Polygons = std::map<FeatureId, Rings>;

std::set<EdgeKey> EdgesOf(const Rings& rings) {
  std::set<EdgeKey> edges;
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      edges.insert(plc::KeyOf(ring[i], ring[(i + 1) % ring.size()]));
    }
  }
  return edges;
}

std::size_t CountAt(const EdgeKey& edge, const Polygons& polygons) {
  std::size_t count = 0;
  for (const auto& [id, rings] : polygons) count += EdgesOf(rings).contains(edge);
  return count;
}

// The surface of each polygon that is part of one.
std::map<FeatureId, FeatureId> NaiveSurfaces(Polygons polygons) {
  for (bool again = true; again;) {
    again = false;
    for (const auto& [id, rings] : polygons) {
      const std::set<EdgeKey> edges = EdgesOf(rings);
      if (std::none_of(edges.begin(), edges.end(),
                       [&](const EdgeKey& edge) { return CountAt(edge, polygons) == 1; })) {
        continue;
      }
      polygons.erase(id);
      again = true;
      break;
    }
  }
  // Pieces: the least id spreads.
  std::map<FeatureId, FeatureId> least;
  for (const auto& [id, rings] : polygons) least[id] = id;
  for (bool again = true; again;) {
    again = false;
    for (const auto& [f, f_rings] : polygons) {
      for (const auto& [g, g_rings] : polygons) {
        const std::set<EdgeKey> of_f = EdgesOf(f_rings), of_g = EdgesOf(g_rings);
        const bool meet = std::any_of(of_f.begin(), of_f.end(),
                                      [&](const EdgeKey& edge) { return of_g.contains(edge); });
        if (!meet || least[f] <= least[g]) continue;
        least[f] = least[g];
        again = true;
      }
    }
  }
  std::set<FeatureId> open;
  for (const auto& [id, rings] : polygons) {
    for (const EdgeKey& edge : EdgesOf(rings)) {
      if (CountAt(edge, polygons) % 2 == 1) open.insert(least[id]);
    }
  }
  std::erase_if(least, [&](const auto& one) { return open.contains(one.second); });
  return least;
}

std::vector<FacetFeature> Features(const Polygons& from, const Polygons& to) {
  std::vector<FacetFeature> features;
  for (const auto& [id, rings] : from) {
    const auto it = to.find(id);
    if (it == to.end() || it->second != rings) features.push_back({id, rings, {}});
  }
  return features;
}

// The squares of a grid of cubes, by the corner of least coordinates.
class Squares {
 public:
  static FeatureId At(int i, int j, int k) {
    return static_cast<FeatureId>(1 + i + 4 * (j + 4 * k));
  }
  static Rings Square(int axis, int i, int j, int k) {
    const auto at = [&](int u, int v) {
      int c[3] = {i, j, k};
      c[(axis + 1) % 3] += u;
      c[(axis + 2) % 3] += v;
      return At(c[0], c[1], c[2]);
    };
    return {{at(0, 0), at(1, 0), at(1, 1), at(0, 1)}};
  }
};

TEST(SurfaceTable, IsWhatTheDefinitionSaysAfterEveryChange) {
  std::size_t closed = 0, changed = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    Polygons present;
    SurfaceTable table;
    std::map<FeatureId, FeatureId> surfaces;
    const int shift = random.Below(100);
    const auto toggle = [&](int axis, int i, int j, int k) {
      const int number = 1 + axis + 3 * (i + 3 * (j + 3 * k));
      const auto id = static_cast<FeatureId>(1 + (number * 37 + shift) % 101);
      if (present.erase(id) == 0) present[id] = Squares::Square(axis, i, j, k);
    };
    for (int revision = 0; revision < 30; ++revision) {
      const Polygons before = present;
      if (random.OneIn(2)) {  // a cube, made or unmade or joined to others
        const int i = random.Below(2), j = random.Below(2), k = random.Below(2);
        for (int side = 0; side < 2; ++side) {
          toggle(0, i + side, j, k);
          toggle(1, i, j + side, k);
          toggle(2, i, j, k + side);
        }
      } else {
        for (int count = 1 + random.Below(3); count > 0; --count) {
          int at[3] = {random.Below(2), random.Below(2), random.Below(2)};
          const int axis = random.Below(3);
          at[axis] += random.Below(2);
          toggle(axis, at[0], at[1], at[2]);
        }
      }
      std::vector<FacetFeature> removed = Features(before, present);
      std::vector<FacetFeature> added = Features(present, before);
      // One that stays moves: it stands in both.
      for (const auto& [id, rings] : present) {
        if (!before.contains(id) || !random.OneIn(8)) continue;
        removed.push_back({id, rings, {}});
        added.push_back({id, rings, {}});
      }
      const auto by_id = [](const FacetFeature& f, const FacetFeature& g) { return f.id < g.id; };
      std::sort(removed.begin(), removed.end(), by_id);
      std::sort(added.begin(), added.end(), by_id);
      const auto changes = table.Update(removed, added);
      const std::map<FeatureId, FeatureId> expected = NaiveSurfaces(present);
      std::vector<SurfaceTable::Change> expected_changes;
      for (const auto& [id, rings] : present) {
        const auto at = [&](const std::map<FeatureId, FeatureId>& all) {
          const auto it = all.find(id);
          return it == all.end() ? kNoFeature : it->second;
        };
        const auto said = table.SurfaceOf(id);
        ASSERT_EQ(said.empty() ? kNoFeature : said[0], at(expected)) << "polygon " << id;
        const bool is_added = std::any_of(added.begin(), added.end(),
                                          [&](const FacetFeature& f) { return f.id == id; });
        if (!is_added && at(surfaces) != at(expected)) {
          expected_changes.push_back({id, at(surfaces), at(expected)});
        }
      }
      ASSERT_EQ(changes, expected_changes);
      surfaces = expected;
      closed += surfaces.size();
      changed += changes.size();
    }
  }
  EXPECT_GT(closed, 1000u);
  EXPECT_GT(changed, 300u);
}

TEST(SurfaceTable, ClosesAHoleWithARimOfItsOwn) {
  // A box whose face 1 has a hole, from which a tube of four leads to nowhere: then its end.
  SurfaceTable table;
  std::vector<FacetFeature> faces = {{1, {{1, 2, 4, 3}, {11, 12, 14, 13}}, {}},
                                     {2, {{1, 2, 6, 5}}, {}},
                                     {3, {{2, 4, 8, 6}}, {}},
                                     {4, {{4, 3, 7, 8}}, {}},
                                     {5, {{3, 1, 5, 7}}, {}},
                                     {6, {{5, 6, 8, 7}}, {}},
                                     {7, {{11, 12, 16, 15}}, {}},
                                     {8, {{12, 14, 18, 16}}, {}},
                                     {9, {{14, 13, 17, 18}}, {}},
                                     {10, {{13, 11, 15, 17}}, {}}};
  table.Update({}, faces);
  for (FeatureId id = 1; id <= 10; ++id) EXPECT_TRUE(table.SurfaceOf(id).empty());
  const std::vector<FacetFeature> end = {{20, {{15, 16, 18, 17}}, {}}};
  EXPECT_EQ(table.Update({}, end).size(), 10u);
  for (FeatureId id = 1; id <= 10; ++id) {
    ASSERT_EQ(table.SurfaceOf(id).size(), 1u);
    EXPECT_EQ(table.SurfaceOf(id)[0], 1u);
  }
  EXPECT_EQ(table.SurfaceOf(20)[0], 1u);
}

}  // namespace
}  // namespace dynmesh
