#include "client/preparation/facet_map.h"

#include <algorithm>
#include <vector>

#include "client/preparation/prepare.h"
#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::preparation {
namespace {

using test::BoxSolid;
using test::Solid;

// The facets of each side of a box become the polygon there.
TEST(FacetMap, FacetsInOnePlaneAreOfOnePolygon) {
  const Solid box = BoxSolid({0, 0, 0}, {1, 2, 3});
  const test::TempFolder folder;
  const auto prepared = Prepare(folder.Write("box.off", box.Off()), {}, {});
  ASSERT_TRUE(prepared.ok()) << prepared.status();
  const std::vector<FeatureId> map =
      NearestPolygons(box.Features(), prepared->geometry.features, 1e-3);
  ASSERT_EQ(map.size(), 12U);
  std::vector<FeatureId> sides;
  for (std::size_t i = 0; i < 12; i += 2) {
    EXPECT_NE(map[i], kNoFeature);
    EXPECT_EQ(map[i], map[i + 1]);
    sides.push_back(map[i]);
  }
  std::ranges::sort(sides);
  EXPECT_EQ(std::unique(sides.begin(), sides.end()) - sides.begin(), 6);
}

TEST(FacetMap, AFacetThatWasKeptIsItsOwn) {
  const std::vector<Feature> features =
      test::DoublePyramid({{1, 0}, {0.3, 0.9}, {-0.8, 0.6}, {-0.7, -0.7}, {0.4, -0.9}}).Features();
  std::vector<FeatureId> wanted;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPolygon) wanted.push_back(f.id);
  }
  EXPECT_EQ(NearestPolygons(features, features, 1e-9), wanted);
}

TEST(FacetMap, WhatIsTooFarOrHasNoAreaIsOfNone) {
  std::vector<Feature> facets = BoxSolid({0, 0, 0}, {1, 1, 1}).Features();
  const std::vector<Feature> prepared = facets;
  facets.push_back(Feature::Point(101, 5, 5, 5));
  facets.push_back(Feature::Polygon(102, {{1, 2, 101}}));  // it hangs on an edge
  facets.push_back(Feature::Polygon(103, {{1, 2, 1}}));
  const std::vector<FeatureId> map = NearestPolygons(facets, prepared, 0.01);
  ASSERT_EQ(map.size(), 14U);
  EXPECT_EQ(map[12], kNoFeature);
  EXPECT_EQ(map[13], kNoFeature);
  EXPECT_EQ(std::count(map.begin(), map.end(), kNoFeature), 2);
}

}  // namespace
}  // namespace dynmesh::preparation
