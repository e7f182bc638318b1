// 3D points and facets: the resulting features, and the errors for invalid files.
#include "core/io/space/space_input.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/io/space/bad_text.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;
using testing::CountRefusalsOfDamage;
using testing::ExpectRefused;

absl::StatusOr<TextReader> NoNodes() { return absl::NotFoundError("a.node: no such file"); }

absl::StatusOr<FileFeatures> Node(const std::string& text) {
  return ParseSpaceNodeText(TextReader("a.node", text));
}
absl::StatusOr<FileFeatures> Poly(const std::string& text) {
  return ParseSpacePolyText(TextReader("a.poly", text), NoNodes);
}
absl::StatusOr<FileFeatures> Smesh(const std::string& text) {
  return ParseSmeshText(TextReader("a.smesh", text), NoNodes);
}

// Two squares of z = 0, the second within the first, and one more that is beside it.
const std::string kSquares =
    "12 3 0 0\n"
    "1 0 0 0\n2 9 0 0\n3 9 9 0\n4 0 9 0\n"
    "5 3 3 0\n6 6 3 0\n7 6 6 0\n8 3 6 0\n"
    "9 20 0 0\n10 22 0 0\n11 22 2 0\n12 20 2 0\n";

TEST(SpaceNodeFile, PointsHaveThreeCoordinates) {
  const auto input = Node("# a\n2 3 1 1\n0 0.5 -0 1e3 7 -1\n1 1 2 3 7 4\n");
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features,
            (std::vector<Feature>{Feature::Point(1, 0.5, -0.0, 1000), Feature::Point(2, 1, 2, 3)}));
  EXPECT_EQ(input->labels.attributes, 1U);
  EXPECT_EQ(input->Where(2), "a.node:4");
}

TEST(SpaceNodeFile, TheDimensionMayBeLeftOutButNotBeAnother) {
  EXPECT_TRUE(Node("1\n1 5 6 7\n").ok());
  EXPECT_EQ(Node("1 2 0 0\n1 5 6\n").status().message(), "a.node:1: dimension 2 is not 3");
}

TEST(SmeshFile, FacetsBecomePolygonsAndSegments) {
  const auto input = Smesh(
      "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n"
      "5 1\n3 0 1 2 7\n3 0\n1 3 -2\n2 3 0 5\n1 2\n2 0 3 5\n"
      "1\n1 .1 .2 .3\n2\n1 .1 .2 .3 4\n2 .1 .2 .3 4 0.5\n");
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->features.size(), 7U);
  EXPECT_EQ(input->point_count, 4U);
  EXPECT_EQ(input->segment_count, 1U);  // that of 0 and 3 stands twice
  EXPECT_EQ(input->features[4], Feature::Segment(5, 4, 1));
  EXPECT_EQ(input->features[5], Feature::Polygon(6, {{1, 2, 3}}));
  EXPECT_EQ(input->features[6], Feature::Polygon(7, {{1, 2, 4}}));  // over two lines
  EXPECT_EQ(input->Where(5), "a.smesh:10");
  EXPECT_EQ(input->Where(7), "a.smesh:8");
  EXPECT_EQ(input->holes, (std::vector<SeedRow>{{{.1, .2, .3}, {}, 14}}));
  EXPECT_EQ(input->regions,
            (std::vector<SeedRow>{{{.1, .2, .3}, {4}, 16}, {{.1, .2, .3}, {4, .5}, 17}}));
}

TEST(SpacePolyFile, APolygonWithAPlaceInItIsAHole) {
  const auto input = Poly(kSquares +
                          "2 1\n3 1 1\n4 1 2 3 4\n4 5 6 7 8\n2 1 5\n1 4 4 0.1\n"
                          "2\n4 9 10 11 12\n1 9\n0\n");
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->features.size(), 15U);
  EXPECT_EQ(input->features[12], Feature::Segment(13, 1, 5));
  EXPECT_EQ(input->features[13], Feature::Polygon(14, {{1, 2, 3, 4}, {5, 6, 7, 8}}));
  EXPECT_EQ(input->features[14], Feature::Polygon(15, {{9, 10, 11, 12}}));
}

TEST(SpacePolyFile, PolygonsSideBySideNeedNoPlace) {
  const auto input = Poly(kSquares + "1\n2\n4 1 2 3 4\n4 9 10 11 12\n");
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features[12], Feature::Polygon(13, {{1, 2, 3, 4}, {9, 10, 11, 12}}));
}

TEST(SpacePolyFile, AnIslandInAHoleIsKeptWithoutAPlace) {
  const std::string points =
      "9 3\n1 0 0 0\n2 0 90 90\n3 90 0 90\n4 0 20 20\n5 0 60 60\n6 40 20 60\n"
      "7 3 30 33\n8 3 40 43\n9 13 30 43\n";
  const std::string facet = "1\n3 1\n3 7 8 9\n3 1 2 3\n3 4 5 6\n";
  EXPECT_TRUE(Poly(points + facet + "1 2 25 27\n").ok());
  // A seed on the island would remove that, too.
  const auto more = Poly(points + "1\n3 2\n3 7 8 9\n3 1 2 3\n3 4 5 6\n1 2 25 27\n2 5 33 38\n");
  EXPECT_NE(std::string(more.status().message()).find("a.poly:17: the place of a hole is on"),
            std::string::npos)
      << more.status();
}

TEST(SpacePolyFile, APlaceIsThatOfTheInnermostPolygonAroundIt) {
  std::string points = "16 3\n", polygons = "1\n4 2\n";
  for (int i = 0; i < 4; ++i) {
    const int lo = i, hi = 20 - i, n = 4 * i;
    const auto point = [&](int k, int x, int y) {
      points += std::to_string(n + k) + " " + std::to_string(x) + " " + std::to_string(y) + " 0\n";
    };
    point(1, lo, lo), point(2, hi, lo), point(3, hi, hi), point(4, lo, hi);
    polygons += "4 " + std::to_string(n + 1) + " " + std::to_string(n + 2) + " " +
                std::to_string(n + 3) + " " + std::to_string(n + 4) + "\n";
  }
  const std::string in_both = points + polygons + "1 1.5 5 0\n2 10 10 0\n";
  EXPECT_TRUE(Poly(in_both).ok()) << Poly(in_both).status();
  const auto twice_in_one = Poly(points + polygons + "1 11 11 0\n2 10 10 0\n");
  EXPECT_TRUE(std::string(twice_in_one.status().message())
                  .starts_with("a.poly:21: a polygon inside its facet without the place"))
      << twice_in_one.status();
}

TEST(SpacePolyFile, TakesItsPointsFromTheNodeFileBesideIt) {
  const TempFolder folder;
  folder.Write("a.node", "3 3 0 0\n0 5 6 7\n1 7 8 9\n2 1 1 1\n");
  for (const char* name : {"a.poly", "a.smesh"}) {
    const bool poly = std::string(name) == "a.poly";
    const std::string path =
        folder.Write(name, poly ? "0 3 0 0\n1 0\n1\n3 0 1 2\n0\n" : "0 3 0 0\n1 0\n3 0 1 2\n0\n");
    const auto input = poly ? ReadSpacePolyFile(path) : ReadSmeshFile(path);
    ASSERT_TRUE(input.ok()) << input.status();
    EXPECT_EQ(input->features[1], Feature::Point(2, 7, 8, 9));
    EXPECT_EQ(input->features[3], Feature::Polygon(4, {{1, 2, 3}}));
    EXPECT_EQ(input->Where(1), folder.Path("a.node") + ":2");
    EXPECT_EQ(input->Where(4), path + ":3");
  }
}

TEST(MalformedSpaceInput, NodesAreRefusedWithFileAndLine) {
  ExpectRefused({{"", 1, "no vertex header"},
                 {"1 4\n1 0 0 0\n", 1, "dimension 4 is neither 2 nor 3"},
                 {"1 3\n1 0 0\n", 2, "4 values according to its header, this one 3"},
                 {"1 3\n1 0 0 inf\n", 2, "z is not a finite number"},
                 {"4000000000 3\n1 0 0 0\n", 2, "ends after 1 of 4000000000"},
                 {"5000000000 3\n1 0 0 0\n", 1, "more than 2^32"},
                 {"1 3\n1 0 0 0\n2 0 0 1\n", 3, "more values after"}},
                "a.node", Node);
}

TEST(MalformedSpaceInput, SmeshFilesAreRefusedWithFileAndLine) {
  const std::string p = "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  ExpectRefused(
      {{p, 5, "no facet header"},
       {"0 3\n1\n", 1, "there is no a.node"},
       {p + "x\n", 6, "number of facets"},
       {p + "1 2\n", 6, "must be 0 or 1"},
       {p + "1 0 0\n", 6, "more than 2 values"},
       {p + "18446744073709551615 0\n3 1 2 3\n", 7, "ends after 1 of 18446744073709551615"},
       {p + "1 0\n18446744073709551615 1 2 3\n", 7, "ends after 3 of"},
       {p + "1 0\n-3 1 2 3\n", 7, "number of corners"},
       {p + "1 0\n0\n", 7, "without corners"},
       {p + "1 0\n3 1 2 5\n", 7, "vertex 5 does not exist"},
       {p + "1 0\n3 1 2 0\n", 7, "vertex 0 does not exist"},
       {p + "1 0\n3 1 2\n", 7, "ends after 2 of 3 corner"},
       {p + "1 0\n3 1 2\nx\n", 8, "vertex number"},
       {p + "1 0\n3 1 2 3 9\n", 7, "from '9' on"},
       {p + "1 1\n3 1 2 3 9 9\n", 7, "from '9' on"},
       {p + "1 1\n3 1 2 3 z\n", 7, "marker"},
       {p + "1 0\n3 1 2 1\n", 7, "visits vertex 1 twice"},
       {p + "1 0\n2 4 4\n", 7, "vertex 4 at both ends"},
       {p + "2 0\n3 1 2 3\n3 3 2 1\n", 8, "same corners as the one on line 7"},
       {p + "0\n1\n1 0 0\n", 8, "a hole row has 4 values, this one 3"},
       {p + "0\n0\n1\n1 0 0 0 1 1 1\n", 9, "a region row has 4 to 6 values"},
       {p + "0\n0\n0\n0\n", 9, "more values after"}},
      "a.smesh", Smesh);
}

TEST(MalformedSpaceInput, PolyFilesAreRefusedWithFileAndLine) {
  const std::string& p = kSquares;  // 13 lines
  ExpectRefused(
      {{p + "1\n", 14, "ends after 0 of 1 facet"},
       {p + "1\nx\n", 15, "number of polygons"},
       {p + "1\n1 -1\n", 15, "number of holes"},
       {p + "1\n1 0 0\n4 1 2 3 4\n", 15, "from '0' on"},
       {p + "1\n2\n4 1 2 3 4\n", 16, "ends after 1 of 2 polygon"},
       {p + "1\n99999999999999999 0\n", 15, "ends after 0 of"},
       {p + "1\n1 99999999999999999\n4 1 2 3 4\n", 16, "ends after 0 of"},
       {p + "1\n1 1\n4 1 2 3 4\n1 0 0\n", 17, "a hole row has 4 values"},
       {p + "1\n1\n4 1 2 3 4 1\n", 16, "from '1' on"},
       {p + "1\n2\n4 1 2 3 4\n4 1 2 6 5\n", 15, "edge between vertices 1 and 2 twice"},
       {p + "1\n2\n4 1 2 3 4\n4 5 6 7 8\n", 17, "without the place of a hole"},
       {p + "1\n2 1\n4 5 6 7 8\n4 1 2 3 4\n1 1 1 0\n", 18, "the place of a hole is on the facet"},
       {p + "1\n1 1\n4 1 2 3 4\n1 1 1 0\n", 17, "the place of a hole is on the facet"},
       {p + "1\n2 1\n4 1 2 3 4\n4 5 6 7 8\n1 4 4 1e300\n", 18, "scale the input"},
       {p + "1\n2\n4 1 9 2 10\n4 5 6 7 8\n", 16, "on one line"},
       {p + "1\n2\n4 1 2 3 4\n3 1 2 3\n", 15, "edge between vertices 1 and 2 twice"}},
      "a.poly", Poly);
  const std::string star = "6 3\n1 0 0 0\n2 3 0 0\n3 6 0 0\n4 4 3 0\n5 3 6 0\n6 2 3 0\n";
  ExpectRefused({{star + "1\n2 1\n6 1 2 3 4 5 6\n3 2 4 6\n1 3 2 0\n", 9, "all of its corners"}},
                "a.poly", Poly);
}

// Truncated or damaged input must give an answer, never a crash.
TEST(MalformedSpaceInput, ByteByByteNeverCrashes) {
  const std::string poly = kSquares +
                           "1 1\n3 1 1\n4 1 2 3 4\n4 5 6 7 8\n2 1 5\n1 4 4 0\n"
                           "1\n1 1 1 1\n1\n1 1 1 1 5\n";
  const std::string smesh = "3 3 0 1\n1 0 0 0 1\n2 1 0 0 1\n3 0 1 0 1\n1 1\n3 1\n2 3 8\n0\n";
  ASSERT_TRUE(Poly(poly).ok()) << Poly(poly).status();
  ASSERT_TRUE(Smesh(smesh).ok()) << Smesh(smesh).status();
  EXPECT_GT(CountRefusalsOfDamage(poly, Poly) + CountRefusalsOfDamage(smesh, Smesh), 1000);
}

}  // namespace
}  // namespace dynmesh::io
