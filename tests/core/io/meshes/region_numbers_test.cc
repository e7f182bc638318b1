#include "core/io/meshes/region_numbers.h"

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "core/io/pictures/colour_ramp.h"
#include "gtest/gtest.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/seed.h"

namespace dynmesh::io {
namespace {

using testing::kLargePolygon;
using testing::SampleMesh;
using testing::SampleMeshWithRegions;

TEST(RegionNumbers, FollowThePolygonsIds) {
  const RegionNumbers regions = NumberRegions(SampleMeshWithRegions());
  EXPECT_EQ(regions.polygons,
            (std::vector<std::vector<FeatureId>>{{12}, {12, 40}, {40}, {40, kLargePolygon}}));
  EXPECT_EQ(regions.numbers, (std::vector<std::uint32_t>{0, 0, 1, 2, 2, 2, 2, 3, 4, 0, 0}));
  EXPECT_EQ(regions.Name(0), "domain");
  EXPECT_EQ(regions.Name(1), "polygon 12");
  EXPECT_EQ(regions.Name(2), "polygons 12 40");
}

TEST(RegionNumbers, OfNoPolygonsAreNone) {
  Mesh mesh = SampleMesh();
  EXPECT_EQ(NumberRegions(mesh), RegionNumbers());
  mesh.regions.assign(mesh.simplex_count(), kNoRegion);  // not canonical, the same
  EXPECT_EQ(NumberRegions(mesh), RegionNumbers());
}

TEST(RegionNumbers, AndBackAreTheSameRegions) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  for (int round = 0; round < 200; ++round) {
    std::vector<std::vector<FeatureId>> rows;
    for (std::size_t k = random() % 6; k > 0; --k) {
      std::set<FeatureId> row;
      do row.insert(1 + random() % 4);
      while (random() % 3 != 0);
      rows.emplace_back(row.begin(), row.end());
    }
    Mesh mesh;
    for (const auto& row : rows) {
      const RegionId id = row.size() == 1 ? row[0] : RegionIdOf(row);
      if (row.size() > 1) mesh.region_sets.push_back({id, row});
    }
    for (std::size_t i = random() % 20; i > 0; --i) {
      const bool none = rows.empty() || random() % 3 == 0;
      const auto& row = none ? std::vector<FeatureId>{} : rows[random() % rows.size()];
      mesh.regions.push_back(none ? 0 : row.size() == 1 ? row[0] : RegionIdOf(row));
      mesh.simplices.insert(mesh.simplices.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    }
    std::sort(mesh.region_sets.begin(), mesh.region_sets.end(),
              [](const RegionSet& a, const RegionSet& b) { return a.id < b.id; });
    Mesh back = mesh;
    SetRegions(NumberRegions(mesh), back);
    Canonicalize(mesh);
    const Mesh before = back;
    Canonicalize(back);
    // The result has no redundant entries.
    EXPECT_EQ(before.regions.empty(), back.regions.empty());
    EXPECT_EQ(before.region_sets, back.region_sets);
    EXPECT_EQ(back.regions, mesh.regions);
    EXPECT_EQ(back.region_sets, mesh.region_sets);
  }
}

TEST(DistinctColour, DiffersFromThatOfOtherRegions) {
  std::set<std::string> colours;
  for (std::size_t n = 1; n <= 100; ++n) {
    const std::string colour = DistinctColour(n);
    EXPECT_EQ(colour.size(), 7U);
    EXPECT_TRUE(colours.insert(colour).second) << n << " " << colour;
  }
}

}  // namespace
}  // namespace dynmesh::io
