// Holes and regions of a .poly as polygons, and the flags that select by polygon.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "client/cli/input.h"
#include "client/cli/mesh_flags.h"
#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli::seed_polygons_test {
namespace {

// A square with two square holes, one of them with a square region inside.
constexpr char kPlate[] =
    "16 2 0 0\n"
    "1 0 0\n2 9 0\n3 9 9\n4 0 9\n"
    "5 1 1\n6 4 1\n7 4 4\n8 1 4\n"
    "9 5 5\n10 8 5\n11 8 8\n12 5 8\n"
    "13 6 6\n14 7 6\n15 7 7\n16 6 7\n"
    "16 0\n"
    "1 1 2\n2 2 3\n3 3 4\n4 4 1\n"
    "5 5 6\n6 6 7\n7 7 8\n8 8 5\n"
    "9 9 10\n10 10 11\n11 11 12\n12 12 9\n"
    "13 13 14\n14 14 15\n15 15 16\n16 16 13\n";

class SeedPolygons : public CommandLineFixture {
 protected:
  Input Load(const std::string& seeds) const {
    absl::StatusOr<Input> input = LoadInput(folder_.Write("p.poly", kPlate + seeds));
    EXPECT_TRUE(input.ok()) << input.status();
    return *std::move(input);
  }
  std::string Folder() const { return folder_.Path(""); }
};

TEST_F(SeedPolygons, HolesComeFirstThenRegionsWithTheNextIds) {
  Input input = Load("2\n1 2 2\n2 5.5 5.5\n2\n1 .5 .5 7 0.1\n2 6.5 6.5\n");
  ASSERT_TRUE(AddSeedPolygons(input).ok());
  ASSERT_EQ(input.features.size(), 37U);
  EXPECT_EQ(input.features[32], Feature::Polygon(33, {{5, 6, 7, 8}}));
  EXPECT_EQ(input.features[33], Feature::Polygon(34, {{9, 10, 11, 12}, {13, 16, 15, 14}}));
  EXPECT_EQ(input.features[34],
            Feature::Polygon(35, {{1, 2, 3, 4}, {5, 8, 7, 6}, {9, 12, 11, 10}}));
  EXPECT_EQ(input.features[35], Feature::Polygon(36, {{13, 14, 15, 16}}));
  EXPECT_EQ(input.hole_polygons, (std::vector<FeatureId>{33, 34}));
  EXPECT_EQ(input.where(34), Folder() + "p.poly:37");
  EXPECT_EQ(input.where(36), Folder() + "p.poly:40");
  EXPECT_EQ(input.where(17), Folder() + "p.poly:19");
  EXPECT_TRUE(input.warnings.empty());
  // The largest area of the first region is that of an equilateral triangle of side sqrt 2 h.
  const Feature& size = input.features[36];
  EXPECT_EQ(size.id, 37U);
  EXPECT_EQ(size.kind, FeatureKind::kSize);
  EXPECT_EQ(size.rings, input.features[34].rings);
  const double h = size.sizing.target;
  EXPECT_LE(std::sqrt(3.0) / 4 * (2 * h * h), 0.1);
  EXPECT_NEAR(std::sqrt(3.0) / 4 * (2 * h * h), 0.1, 1e-12);
}

// As in Triangle.
TEST_F(SeedPolygons, WhatMarksNothingIsLeftOutWithAWarning) {
  Input input = Load("3\n1 20 20\n2 2 2\n3 3 3\n2\n1 2 3\n2 -1 0\n");
  ASSERT_TRUE(AddSeedPolygons(input).ok());
  ASSERT_EQ(input.features.size(), 33U);
  EXPECT_EQ(input.features[32].id, 34U);  // ids follow the row, whatever is left out
  ASSERT_EQ(input.warnings.size(), 4U);
  const std::string file = Folder() + "p.poly:";
  EXPECT_EQ(input.warnings[0],
            file + "36: the place of a hole is outside everything, and is ignored");
  EXPECT_EQ(input.warnings[1], file +
                                   "38: the place of a hole is in the same face as the hole at " +
                                   file + "37, and is ignored");
  EXPECT_EQ(input.warnings[2], file +
                                   "40: the place of a region is in the same face as the hole at " +
                                   file + "37, and is ignored");
  EXPECT_EQ(input.warnings[3],
            file + "41: the place of a region is outside everything, and is ignored");
}

TEST_F(SeedPolygons, OnASegmentAreRefused) {
  Input input = Load("1\n1 0 5\n");
  const absl::Status status = AddSeedPolygons(input);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(std::string(status.message()),
            Folder() + "p.poly:36: the place of a hole is on segment 20: move it to one side");
}

TEST_F(SeedPolygons, AreImportedAsPolygonsOrStaySeeds) {
  folder_.Write("p.poly", std::string(kPlate) + "1\n1 2 2\n1\n1 6.5 6.5 7 0.1\n");
  ASSERT_EQ(Run("import p.poly -o p.dynmesh").code, 0);
  const std::string script = folder_.Read("p.dynmesh");
  EXPECT_NE(script.find("add polygon 33 5 6 7 8\nadd polygon 34 13 14 15 16\n"), std::string::npos)
      << script;
  ASSERT_EQ(Run("import p.poly -o q.poly").code, 0);
  EXPECT_TRUE(folder_.Read("q.poly").ends_with("\n16 16 13\n1\n1 2 2\n1\n1 6.5 6.5 7 0.1\n"));
  const Outcome outcome = Run("import p.dynmesh -o r.poly");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("no place for the 2 polygon(s); write a .dynmesh"), std::string::npos)
      << outcome.err;
}

// Seeds are located among the final segments.
TEST_F(SeedPolygons, AreMarkedAfterCleaning) {
  // Two long bars that cross two others: the hole is the square between them.
  folder_.Write("bars.poly",
                "8 2 0 0\n1 0 1\n2 3 1\n3 0 2\n4 3 2\n5 1 0\n6 1 3\n7 2 0\n8 2 3\n"
                "4 0\n1 1 2\n2 3 4\n3 5 6\n4 7 8\n1\n1 1.5 1.5\n");
  Outcome outcome = Run("import bars.poly -o raw.dynmesh");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("holes and regions left out"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder_.Read("raw.dynmesh").find("polygon"), std::string::npos);
  outcome = Run("import bars.poly --clean -o clean.dynmesh");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string script = folder_.Read("clean.dynmesh");
  const std::size_t at = script.find("add polygon ");
  ASSERT_NE(at, std::string::npos);
  const std::string line = script.substr(at, script.find('\n', at) - at);
  EXPECT_EQ(std::count(line.begin(), line.end(), ' '), 6) << line;  // four corners
}

TEST_F(SeedPolygons, MeshAndAreJudged) {
  folder_.Write("p.poly", std::string(kPlate) + "2\n1 2 2\n2 6.5 6.5\n1\n1 .5 .5\n");
  folder_.Write("other.poly", std::string(kPlate) + "2\n1 2 2\n2 6.5 6.5\n0\n");
  ASSERT_EQ(Run("mesh p.poly -o m.node").code, 0);
  const Outcome good = Run("verify m.node --input p.poly");
  EXPECT_EQ(good.code, 0) << good.out;
  const Outcome bad = Run("verify m.node --input other.poly");
  EXPECT_EQ(bad.code, 1);
  EXPECT_NE(bad.out.find("regions      FAILED"), std::string::npos) << bad.out;
  const Outcome stats = Run("stats m.node --json");
  EXPECT_NE(stats.out.find("{\"polygons\": [\"33\"], \"simplices\": "), std::string::npos);
  ASSERT_EQ(Run("mesh p.poly --outside holes -o h.node").code, 0);
  EXPECT_EQ(folder_.Read("h.ele").find("# dynmesh region 1 33\n"), std::string::npos);
  EXPECT_NE(folder_.Read("h.ele").find("# dynmesh region 1 35\n"), std::string::npos);
  EXPECT_EQ(Run("diff m.node h.node").code, 1);
}

TEST(OutsideFlag, TakesIdsOrHoles) {
  const std::vector<FeatureId> holes = {7, 9};
  mesh_data::RegionChoice choice;
  EXPECT_TRUE(ApplyOutsideFlag("", &holes, choice).ok());
  EXPECT_TRUE(choice.IsEverything());
  EXPECT_TRUE(ApplyOutsideFlag("holes", &holes, choice).ok());
  EXPECT_EQ(choice.out, holes);
  EXPECT_TRUE(ApplyOutsideFlag("4,3,4", &holes, choice).ok());
  EXPECT_EQ(choice.out, (std::vector<FeatureId>{3, 4}));
  EXPECT_FALSE(ApplyOutsideFlag("holes", nullptr, choice).ok());
  for (const char* bad : {"0", "x", "1,", ",1", "1 2", "-1", "18446744073709551615"}) {
    EXPECT_FALSE(ApplyOutsideFlag(bad, &holes, choice).ok()) << bad;
  }
}

TEST_F(SeedPolygons, FlagsThatChooseByPolygonAreChecked) {
  folder_.Write("p.poly", kPlate);
  folder_.Write("s.dynmesh", "mesh box=0,0,1,1\nadd point 1 .5 .5\n");
  EXPECT_EQ(Run("mesh p.poly --region x").code, 2);
  EXPECT_EQ(Run("mesh p.poly --outside all").code, 2);
  EXPECT_EQ(Run("replay s.dynmesh --outside holes -o m.node").code, 2);
  // No triangle lies in a polygon if there is none.
  const Outcome none = Run("mesh p.poly --region any --json -o m.node");
  EXPECT_EQ(none.code, 2) << none.out;
  EXPECT_NE(none.err.find("the mesh has no polygons"), std::string::npos) << none.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("m.ele")));
  EXPECT_EQ(Run("mesh p.poly --outside 7").code, 2);
  EXPECT_EQ(Run("mesh p.poly --outside holes").code, 0);  // a file without holes
  EXPECT_EQ(Run("replay s.dynmesh --region any -o m.node").code, 2);
}

}  // namespace
}  // namespace dynmesh::cli::seed_polygons_test
