#include "client/preparation/open_edges.h"

#include <vector>

#include "gtest/gtest.h"

namespace dynmesh::preparation {
namespace {

// A tetrahedron, and triangles that hang on it: 15 at an edge, 16 at 15, 17 beside 16.
std::vector<Feature> TetrahedronWithFlaps() {
  return {Feature::Point(1, 0, 0, 0),        Feature::Point(2, 1, 0, 0),
          Feature::Point(3, 0, 1, 0),        Feature::Point(4, 0, 0, 1),
          Feature::Point(5, 2, 2, 0),        Feature::Point(6, 3, 0, 0),
          Feature::Point(7, 4, 4, 0),        Feature::Polygon(11, {{1, 3, 2}}),
          Feature::Polygon(12, {{1, 2, 4}}), Feature::Polygon(13, {{2, 3, 4}}),
          Feature::Polygon(14, {{3, 1, 4}}), Feature::Polygon(15, {{2, 3, 5}}),
          Feature::Polygon(16, {{2, 5, 6}}), Feature::Polygon(17, {{5, 7, 6}})};
}

TEST(OpenEdges, AreThoseWithOneFace) {
  std::vector<Feature> features = TetrahedronWithFlaps();
  EXPECT_EQ(OpenEdgesOf(features).size(), 4U);  // 3 5, 2 6, 5 7, 6 7
  std::erase_if(features, [](const Feature& f) { return f.id >= 15; });
  EXPECT_TRUE(OpenEdgesOf(features).empty());
}

TEST(OpenEdges, FlapsGoOneAfterTheOtherWithTheirPoints) {
  std::vector<Feature> features = TetrahedronWithFlaps();
  EXPECT_EQ(DropFlaps({15, 16, 17}, features), 3U);
  EXPECT_EQ(features.size(), 8U);
  EXPECT_TRUE(OpenEdgesOf(features).empty());
}

TEST(OpenEdges, AFaceThatIsNotDoubledStaysAndKeepsWhatIsBehindIt) {
  std::vector<Feature> features = TetrahedronWithFlaps();
  EXPECT_EQ(DropFlaps({17}, features), 1U);
  EXPECT_EQ(OpenEdgesOf(features).size(), 3U);
  // A doubled face of the closed part stays.
  EXPECT_EQ(DropFlaps({11, 12}, features), 0U);
}

// A slit of 1e-3, and a triangle that is missing.
TEST(OpenEdges, MayBeClosedWhereTheyFaceEachOther) {
  const std::vector<Feature> slit = {
      Feature::Point(1, 0, 0, 0),        Feature::Point(2, 10, 0, 0),
      Feature::Point(3, 5, 1e-3, 0),     Feature::Point(4, 5, -5, 0),
      Feature::Point(5, 5, 5, 0),        Feature::Polygon(11, {{1, 4, 2}}),
      Feature::Polygon(12, {{1, 3, 5}}), Feature::Polygon(13, {{3, 2, 5}}),
      Feature::Polygon(14, {{1, 5, 4}}), Feature::Polygon(15, {{2, 4, 5}})};
  EXPECT_EQ(OpenEdgesOf(slit).size(), 3U);
  EXPECT_TRUE(MayBeClosed(OpenEdgesOf(slit), 1e-3));
  EXPECT_FALSE(MayBeClosed(OpenEdgesOf(slit), 1e-5));
  std::vector<Feature> hole = TetrahedronWithFlaps();
  std::erase_if(hole, [](const Feature& f) { return f.id >= 14; });
  EXPECT_EQ(OpenEdgesOf(hole).size(), 3U);
  EXPECT_FALSE(MayBeClosed(OpenEdgesOf(hole), 1e-2));
}

}  // namespace
}  // namespace dynmesh::preparation
