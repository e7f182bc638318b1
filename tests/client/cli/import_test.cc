// `dynmesh import`, and maps as input of the other commands.
#include <filesystem>
#include <string>

#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

class Import : public CommandLineFixture {
 protected:
  void WriteInputs() const {
    folder_.Write("square.geojson",
                  "{\"type\": \"Polygon\", \"coordinates\":\n"
                  "[[[0, 0], [1, 0], [1, 0.1], [0, 1], [0, 0]]]}");
    // Two bars that cross, a third that ends on the first, one point twice.
    folder_.Write("messy.poly",
                  "8 2 0 0\n1 0 0\n2 1 1\n3 0 1\n4 1 0\n5 0.25 0.25\n6 0.25 0\n7 1 0\n8 .9 .1\n"
                  "3 0\n1 1 2\n2 3 4\n3 6 5\n0\n");
    folder_.Write("squares.topojson",
                  "{\"type\": \"Topology\", \"transform\": {\"scale\": [0.1, 0.1], "
                  "\"translate\": [-1, 5]},\n"
                  "\"objects\": {\"a\": {\"type\": \"Polygon\", \"arcs\": [[0]]}},\n"
                  "\"arcs\": [[[0, 0], [9, 0], [0, 3], [-9, -3]]]}");
  }
};

TEST_F(Import, MapsAreInputOfEveryCommand) {
  WriteInputs();
  for (const std::string name : {"square.geojson", "squares.topojson"}) {
    ASSERT_EQ(Run("mesh " + name + " -o m.node").code, 0) << name;
    EXPECT_EQ(Run("verify m.node --input " + name).code, 0) << name;
  }
  folder_.Write("map.json", folder_.Read("squares.topojson"));
  EXPECT_EQ(Value(Run("mesh map.json --json").out, "hash"),
            Value(Run("mesh squares.topojson --json").out, "hash"));
}

TEST_F(Import, APolyOfAMapMeshesLikeTheMap) {
  WriteInputs();
  for (const std::string out : {"m.poly", "m.dynmesh"}) {
    const Outcome outcome = Run("import squares.topojson --json -o " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(Value(outcome.out, "points"), "3");
    EXPECT_EQ(Value(outcome.out, "segments"), "3");
    EXPECT_EQ(Value(outcome.out, "cleaned"), "false");
    EXPECT_EQ(Value(Run("mesh --json " + out).out, "hash"),
              Value(Run("mesh squares.topojson --segments --json").out, "hash"));
  }
  EXPECT_TRUE(folder_.Read("m.dynmesh").starts_with("mesh dim=2 box=-1,5,"));
  EXPECT_EQ(Run("replay m.dynmesh --check 1").code, 0);
}

TEST_F(Import, WhatIsCleanedMeshes) {
  WriteInputs();
  EXPECT_EQ(Run("mesh messy.poly --exact").code, 2);
  const Outcome outcome = Run("import messy.poly --clean -o clean.poly --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 5U) << outcome.out;
  // Point 7 is point 4; 5 is on segment 9, 8 on segment 10; these two cross.
  EXPECT_EQ(lines[0],
            "{\"change\": \"point merged\", \"ids\": [\"7\", \"4\"], \"x\": 1, \"y\": 0, "
            "\"to_x\": 1, \"to_y\": 0}");
  EXPECT_NE(lines[1].find("\"segment split\", \"ids\": [\"9\", \"5\"]"), std::string::npos);
  EXPECT_NE(lines[2].find("\"segment split\", \"ids\": [\"10\", \"8\"]"), std::string::npos);
  EXPECT_NE(lines[3].find("\"segments crossed\""), std::string::npos);
  const std::string& summary = lines[4];
  EXPECT_EQ(Value(summary, "summary"), "true");
  EXPECT_EQ(Value(summary, "points_read"), "8");
  EXPECT_EQ(Value(summary, "points"), "8");
  EXPECT_EQ(Value(summary, "segments_read"), "3");
  EXPECT_EQ(Value(summary, "segments"), "7");
  EXPECT_EQ(Value(summary, "point_merged"), "1");
  EXPECT_EQ(Value(summary, "segment_split"), "2");
  EXPECT_EQ(Value(summary, "segments_crossed"), "1");
  EXPECT_EQ(Value(summary, "changes"), "4");
  ASSERT_EQ(Run("mesh clean.poly -o m.node").code, 0);
  EXPECT_EQ(Run("verify m.node --input clean.poly").code, 0);
  // As text, and as a script, which keeps ids.
  const Outcome text = Run("import messy.poly --clean -o clean.dynmesh");
  ASSERT_EQ(text.code, 0);
  EXPECT_NE(text.out.find("segments crossed   1\n"), std::string::npos) << text.out;
  EXPECT_NE(folder_.Read("clean.dynmesh").find("add point 8 0.9 0.1\n"), std::string::npos);
  EXPECT_EQ(folder_.Read("clean.dynmesh").find("add point 7 "), std::string::npos);
}

TEST_F(Import, CleaningCleanInputGivesTheSameFile) {
  WriteInputs();
  ASSERT_EQ(Run("import squares.topojson -o a.poly").code, 0);
  ASSERT_EQ(Run("import a.poly --clean -o b.poly").code, 0);
  EXPECT_EQ(folder_.Read("a.poly"), folder_.Read("b.poly"));
}

TEST_F(Import, PolygonsOfAMapStayPolygons) {
  // Two overlapping squares and a line that ends on a border.
  folder_.Write("m.geojson", R"({"type": "FeatureCollection", "features": [
{"type": "Feature", "id": "a7", "properties": {"name": "Left"}, "geometry":
 {"type": "Polygon", "coordinates": [[[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]]]}},
{"type": "Feature", "properties": {}, "geometry":
 {"type": "Polygon", "coordinates": [[[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]]]}},
{"type": "Feature", "properties": {}, "geometry":
 {"type": "Polygon", "coordinates": [[[5, 5], [6, 6], [5, 5], [5, 5]]]}},
{"type": "Feature", "properties": {}, "geometry":
 {"type": "LineString", "coordinates": [[0, 1], [0.5, 1]]}}]})");
  const Outcome outcome = Run("import m.geojson --clean --polygons --json -o m.dynmesh");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> lines = Lines(outcome.out);
  ASSERT_GE(lines.size(), 3U);
  // Points 1 to 10, segment 11: the ring of two places is dropped when it is read.
  EXPECT_EQ(lines[lines.size() - 3], "{\"polygon\": \"12\", \"id\": \"a7\", \"name\": \"Left\"}");
  EXPECT_EQ(lines[lines.size() - 2], "{\"polygon\": \"13\"}");
  const std::string& summary = lines.back();
  EXPECT_EQ(Value(summary, "polygons_read"), "2");
  EXPECT_EQ(Value(summary, "polygons"), "2");
  EXPECT_EQ(Value(summary, "segments"), "1");
  EXPECT_EQ(Value(summary, "rings_dropped"), "1");
  EXPECT_EQ(Value(summary, "segments_crossed"), "2");
  ASSERT_EQ(Run("mesh m.dynmesh -o m.node").code, 0);
  const Outcome verified = Run("verify m.node --input m.dynmesh");
  EXPECT_EQ(verified.code, 0) << verified.out;
  // Left alone, right alone and both.
  const std::string stats = Run("stats m.node").out;
  for (const char* region : {"3  12 Left\n", "3  13\n", "1  12 13\n"}) {
    EXPECT_NE(stats.find(region), std::string::npos) << region << stats;
  }
  // Unchanged: polygons, which a .poly cannot represent.
  ASSERT_EQ(Run("import m.geojson --polygons -o raw.dynmesh").code, 0);
  EXPECT_NE(folder_.Read("raw.dynmesh").find("add polygon 14 1 2 3 4\n"), std::string::npos);
  EXPECT_EQ(Run("import m.geojson --polygons -o raw.poly").code, 2);
  // And segments as before.
  EXPECT_EQ(Value(Run("import m.geojson --json -o raw.poly").out, "polygons"), "0");
}

TEST_F(Import, TheToleranceSaysWhatIsOne) {
  folder_.Write("near.poly", "3 2 0 0\n1 0 0\n2 1 0\n3 0.5 0.01\n1 0\n1 1 2\n0\n");
  EXPECT_EQ(Value(Run("import near.poly --clean --json -o c.poly").out, "changes"), "0");
  EXPECT_EQ(
      Value(Lines(Run("import near.poly --clean --tolerance 0.1 --json -o c.poly").out).back(),
            "segment_split"),
      "1");
}

TEST_F(Import, TheBoxIsTheMeshLines) {
  WriteInputs();
  ASSERT_EQ(Run("import square.geojson --box=-1,-1,2,2 -o a.dynmesh").code, 0);
  EXPECT_TRUE(folder_.Read("a.dynmesh").starts_with("mesh dim=2 box=-1,-1,2,2 "));
  const Outcome outside = Run("import square.geojson --box 0,0,0.5,2 -o b.dynmesh");
  EXPECT_EQ(outside.code, 2);
  EXPECT_NE(outside.err.find("square.geojson:2: point 2 "), std::string::npos) << outside.err;
}

TEST_F(Import, SizingFeaturesStayInScripts) {
  folder_.Write("a.txt", "mesh box=0,0,1,1\nadd point 1 .1 .2\nadd size 2 point .5 .5 .01\n");
  const Outcome script = Run("import a.txt --clean -o a.dynmesh");
  ASSERT_EQ(script.code, 0) << script.err;
  EXPECT_EQ(Value(Run("mesh a.dynmesh --json").out, "hash"),
            Value(Run("mesh a.txt --json").out, "hash"));
  const Outcome poly = Run("import a.txt -o a.poly");
  EXPECT_EQ(poly.code, 0);
  EXPECT_NE(poly.err.find("1 sizing feature(s) left out"), std::string::npos) << poly.err;
}

TEST_F(Import, BadUsageAndBadInputAreTwo) {
  WriteInputs();
  folder_.Write("bad.geojson", "{\"type\": \"Point\",\n\"coordinates\": [1]}");
  folder_.Write("bad.json", "{\"type\":\n");
  folder_.Write("flat.node", "1 2 0 0\n1 1e300 0\n");
  for (const char* arguments :
       {"import", "import messy.poly", "import -o a.poly", "import none.json -o a.poly",
        "import bad.geojson -o a.poly", "import bad.json -o a.poly", "import messy.poly -o a.node",
        "import messy.poly -o a", "import messy.poly -o a.poly --tolerance 1",
        "import messy.poly -o a.poly --clean --tolerance 0",
        "import messy.poly -o a.poly --clean --tolerance 1e-15",
        "import messy.poly -o a.poly --clean --tolerance nan",
        "import messy.poly -o a.dynmesh --polygons", "import messy.poly -o a.poly --box 1",
        "import flat.node -o a.poly --clean"}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.err;
    EXPECT_NE(outcome.err, "") << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
  }
  EXPECT_NE(Run("mesh bad.geojson").err.find("bad.geojson:2: "), std::string::npos);
}

TEST_F(Import, WarnsOfEdgesAcrossTheAntimeridianAndOfHeights) {
  folder_.Write("a.geojson",
                R"({"type": "LineString", "coordinates": [[179, 5, 1], [-179, 6, 1]]})");
  const Outcome outcome = Run("import a.geojson -o a.poly");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("antimeridian"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("2 height(s) ignored"), std::string::npos) << outcome.err;
}

std::string Polygon(const std::string& rings) {
  return "{\"type\": \"Polygon\", \"coordinates\": [" + rings + "]}\n";
}
const std::string kSquare = "[[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]";

// Rings that the format does not allow are mended by --clean, and refused without.
TEST_F(Import, RingsThatAreOpenOrTooShortAreMended) {
  const struct {
    std::string rings, key;
    int points, segments;
  } cases[] = {
      {"[[0, 0], [4, 0], [4, 4], [0, 4]]", "rings_closed", 4, 4},
      {"[[0, 0], [4, 0], [4, 4]]", "rings_closed", 3, 3},
      {kSquare + ", []", "rings_dropped", 4, 4},
      {kSquare + ", [[1, 1], [2, 2]]", "rings_dropped", 4, 4},
      {kSquare + ", [[1, 1], [2, 1], [1, 1]]", "rings_dropped", 4, 4},
      {kSquare + ", [[1, 1], [1, 1], [2, 1], [1, 1]]", "rings_dropped", 4, 4},
      {kSquare + ", [[2, 2]]", "rings_to_points", 5, 4},
      {kSquare + ", [[2, 2], [2, 2], [2, 2], [2, 2]]", "rings_to_points", 5, 4},
  };
  for (const auto& c : cases) {
    folder_.Write("r.geojson", Polygon(c.rings));
    for (const std::string polygons : {"", " --polygons"}) {
      const Outcome outcome = Run("import r.geojson --clean --json -o c.dynmesh" + polygons);
      ASSERT_EQ(outcome.code, 0) << c.rings << outcome.err;
      EXPECT_EQ(Value(outcome.out, c.key), "1") << c.rings;
      EXPECT_EQ(Value(outcome.out, "points"), std::to_string(c.points)) << c.rings;
      EXPECT_EQ(Value(outcome.out, "segments"),
                polygons.empty() ? std::to_string(c.segments) : "0");
      EXPECT_EQ(Value(outcome.out, "polygons"), polygons.empty() ? "0" : "1");
      ASSERT_EQ(Run("mesh c.dynmesh --inside -o c.node").code, 0) << c.rings;
      EXPECT_EQ(Run("verify c.node --input c.dynmesh").code, 0) << c.rings;
    }
    EXPECT_NE(Run("import r.geojson --clean -o c.dynmesh")
                  .out.find(c.key == "rings_closed"    ? "rings closed       1"
                            : c.key == "rings_dropped" ? "rings dropped      1"
                                                       : "rings to points    1"),
              std::string::npos);
  }
  folder_.Write("open.geojson", Polygon(cases[0].rings));
  EXPECT_EQ(Run("mesh open.geojson --exact").code, 2);
  EXPECT_EQ(Run("import open.geojson -o c.dynmesh").code, 2);
  // A position that is no position is no ring to be mended.
  folder_.Write("bad.geojson", Polygon("[[0, 0], [4]]"));
  EXPECT_EQ(Run("import bad.geojson --clean -o c.dynmesh").code, 2);
}

TEST_F(Import, WhenNothingIsLeftItSaysSo) {
  // No area; no area of a polygon of two; only a ring that is dropped.
  for (const std::string rings : {"[[0, 0], [2, 0], [4, 0], [0, 0]]",
                                  "[[0, 0], [4, 0], [0, 0], [0, 0]]", "[[1, 1], [2, 2]]"}) {
    folder_.Write("n.geojson", Polygon(rings));
    const Outcome outcome = Run("import n.geojson --polygons --clean -o n.dynmesh");
    EXPECT_EQ(outcome.code, 2) << rings;
    EXPECT_NE(outcome.err.find("nothing is left: 0 polygons and 0 segments"), std::string::npos)
        << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.Path("n.dynmesh"))) << rings;
  }
  folder_.Write("n.geojson", Polygon("[[0, 0], [2, 0], [4, 0], [0, 0]]"));
  EXPECT_NE(Run("import n.geojson --polygons --clean -o n.dynmesh")
                .err.find("polygon 4 at (0, 0) (n.geojson:1)"),
            std::string::npos);
  // A point far away makes the tolerance larger than all else.
  folder_.Write("far.geojson",
                Polygon("[[0, -2], [2, 2], [0, 4], [-3, 3], [0, -2]], "
                        "[[1.4e38, 1.4e38], [0, 0], [0, 1], [1, 0], [1.4e38, 1.4e38]]"));
  const Outcome far = Run("import far.geojson --polygons --clean -o n.dynmesh");
  EXPECT_EQ(far.code, 2);
  EXPECT_NE(far.err.find("point 5 is so far from all others"), std::string::npos) << far.err;
  // Points alone are what they were.
  folder_.Write("p.node", "2 2 0 0\n1 0 0\n2 1 1\n");
  EXPECT_EQ(Run("import p.node --clean -o p.poly").code, 0);
  // Of two polygons one is left: a warning.
  folder_.Write("two.geojson", "{\"type\": \"GeometryCollection\", \"geometries\": [" +
                                   Polygon(kSquare) + ", " +
                                   Polygon("[[5, 0], [6, 0], [7, 0], [5, 0]]") + "]}");
  const Outcome two = Run("import two.geojson --polygons --clean -o n.dynmesh");
  EXPECT_EQ(two.code, 0) << two.err;
  EXPECT_NE(two.err.find("1 polygon(s) without an area left out: polygon 9 at (5, 0)"),
            std::string::npos)
      << two.err;
}

// Few points that need millions of vertices: the error tells the tolerance that helps, and it does.
TEST_F(Import, TheToleranceThatIsAdvisedClosesTheFinestGap) {
  const std::string inputs[] = {
      Polygon("[[0, 0], [1, 0], [0.5, 1], [0, 0]], "
              "[[0.1, 1e-7], [0.9, 1e-7], [0.5, 0.5], [0.1, 1e-7]]"),
      Polygon("[[4e-07, -4e-07], [4e-07, 0], [0, 0], [-1.2e-06, 0], [-8.66, 0], [-8.66, 1.34], "
              "[-10, -4e-07], [4e-07, -4e-07]]"),
      "{\"type\": \"MultiPolygon\", \"coordinates\": [[[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]], "
      "[[[1.00000001, 0], [2, 0], [2, 1], [1.00000001, 1], [1.00000001, 0]]]]}"};
  for (const std::string& input : inputs) {
    folder_.Write("g.geojson", input);
    const Outcome refused = Run("mesh g.geojson --exact --max-vertices 1000000");
    EXPECT_EQ(refused.code, 1);
    EXPECT_NE(refused.err.find("apart: what is between them takes at least"), std::string::npos)
        << refused.err;
    EXPECT_NE(refused.err.find("g.geojson:1: "), std::string::npos) << refused.err;
    const std::string flag = "--clean --tolerance ";
    const std::size_t at = refused.err.find(flag);
    ASSERT_NE(at, std::string::npos) << refused.err;
    const std::string tolerance = refused.err.substr(
        at + flag.size(), refused.err.find(' ', at + flag.size()) - at - flag.size());
    // Without it, cleaning warns; with it, a mesh of some thousand vertices is made.
    const Outcome warned = Run("import g.geojson --polygons --clean -o w.dynmesh");
    EXPECT_EQ(warned.code, 0);
    EXPECT_NE(warned.err.find(flag + tolerance), std::string::npos) << warned.err;
    ASSERT_EQ(Run("import g.geojson --polygons --clean -o c.dynmesh --tolerance " + tolerance).code,
              0);
    const Outcome made = Run("mesh c.dynmesh --inside --json -o c.node");
    ASSERT_EQ(made.code, 0) << made.err;
    EXPECT_LT(std::stoi(Value(made.out, "vertices")), 10'000);
    EXPECT_EQ(Run("verify c.node --input c.dynmesh").code, 0);
  }
}

}  // namespace
}  // namespace dynmesh::cli
