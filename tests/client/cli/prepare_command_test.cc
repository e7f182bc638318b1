// `mesh` of files as they come: what is mended, and which part is written.
#include <string>

#include "tests/client/cli/command_line.h"
#include "tests/client/preparation/solids.h"

namespace dynmesh::cli {
namespace {

using test::BoxSolid;
using test::CrackedBox;
using test::Solid;

class PrepareCommand : public CommandLineFixture {};

TEST_F(PrepareCommand, TheInsideOfASurfaceIsWritten) {
  folder_.Write("box.off", BoxSolid({0, 0, 0}, {1, 1, 2}).Off());
  ASSERT_EQ(Run("mesh box.off -o in.node").code, 0);
  EXPECT_EQ(Run("verify in.node --input box.off").code, 0);
  ASSERT_EQ(Run("mesh box.off --surroundings -o all.node").code, 0);
  EXPECT_EQ(Run("verify all.node --input box.off").code, 0);
  const Outcome in = Run("stats in.node --json"), all = Run("stats all.node --json");
  EXPECT_LT(std::stoi(Value(in.out, "simplices")), std::stoi(Value(all.out, "simplices")));
  EXPECT_EQ(Value(Run("mesh box.off --inside --json").out, "hash"),
            Value(Run("mesh box.off --json").out, "hash"));
}

TEST_F(PrepareCommand, TheMapTellsTheFacetsOfEachPolygon) {
  folder_.Write("box.off", BoxSolid({0, 0, 0}, {1, 1, 2}).Off());
  ASSERT_EQ(Run("mesh box.off --map map.json").code, 0);
  const std::string map = folder_.Read("map.json");
  EXPECT_EQ(map.rfind("{\"facets\": 12, \"of_none\": [], \"polygons\": [\n", 0), 0U) << map;
  for (const std::string pair : {"[0, 1]", "[2, 3]", "[4, 5]", "[6, 7]", "[8, 9]", "[10, 11]"}) {
    EXPECT_NE(map.find("\"facets\": " + pair + "}"), std::string::npos) << pair << map;
  }
  // All of them have their own ids if they are kept.
  ASSERT_EQ(Run("mesh box.off --keep-facets --map map.json").code, 0);
  EXPECT_NE(folder_.Read("map.json").find("{\"id\": \"9\", \"facets\": [0]}"), std::string::npos);
  EXPECT_EQ(Run("mesh box.off --map box.off").code, 2);
  folder_.Write("square.node", "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n");
  EXPECT_EQ(Run("mesh square.node --map map.json").code, 2);
}

// Faces of a needle cross each other at next to no angle. Cut there, a mesh accepts them, and does
// not end.
TEST_F(PrepareCommand, WhatIsTooFineIsMendedWithALargerTolerance) {
  folder_.Write("needle.off",
                "OFF\n6 8 0\n0.05685775 0.0002748734 -2.727833e-05\n"
                "-0.06876524 0.02404099 4.281872e-05\n-0.07475285 0.0003367258 -2.022409e-06\n"
                "-0.04555911 -0.01938796 -3.444687e-05\n-0.138661 -0.008725009 2.689457e-05\n"
                "-0.079188 -0.005978653 1\n3 0 1 4\n3 1 0 5\n3 1 2 4\n3 2 1 5\n3 2 3 4\n"
                "3 3 2 5\n3 3 0 4\n3 0 3 5\n");
  const Outcome made = Run("mesh needle.off --json -o m.node");
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string flag = "--mending-tolerance ";
  const std::size_t at = made.err.rfind(flag);
  ASSERT_NE(at, std::string::npos) << made.err;
  const std::string tolerance =
      made.err.substr(at + flag.size(), made.err.find('\n', at) - at - flag.size());
  EXPECT_LE(std::stod(tolerance), std::stod(Value(made.out, "within")));
  EXPECT_EQ(std::stod(Value(made.out, "least_tolerance")), std::stod(tolerance));
  EXPECT_GE(std::stod(Value(made.out, "mending_tolerance")), std::stod(tolerance));
  EXPECT_EQ(Run("verify m.node --input needle.off --mending-tolerance " + tolerance).code, 0);
  const Outcome same = Run("mesh needle.off --json --mending-tolerance " + tolerance);
  EXPECT_EQ(Value(same.out, "hash"), Value(made.out, "hash"));
  // A limit that was asked for is kept.
  EXPECT_NE(Run("mesh needle.off --max-vertices 1000000").code, 0);
  EXPECT_EQ(Run("mesh needle.off --mending-tolerance 0").code, 2);
  EXPECT_EQ(Run("mesh needle.off --mending-tolerance 1e-5 --exact").code, 2);
}

TEST_F(PrepareCommand, ACavityIsNoInside) {
  Solid hollow = BoxSolid({0, 0, 0}, {3, 3, 3}), cavity = BoxSolid({1, 1, 1}, {2, 2, 2});
  hollow.Add(cavity);
  folder_.Write("full.off", hollow.Off());
  Solid turned = BoxSolid({0, 0, 0}, {3, 3, 3});
  cavity.TurnInsideOut();
  turned.Add(cavity);
  folder_.Write("hollow.off", turned.Off());
  const auto simplices = [&](const std::string& file) {
    const Outcome made = Run("mesh " + file + " --json -o m.node");
    EXPECT_EQ(made.code, 0) << made.err;
    EXPECT_EQ(Run("verify m.node --input " + file).code, 0);
    return std::stoi(Value(made.out, "simplices"));
  };
  EXPECT_LT(simplices("hollow.off"), simplices("full.off"));
}

TEST_F(PrepareCommand, OfAnOpenSurfaceTheWholeBoxIsWritten) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1});
  solid.faces.resize(10);
  folder_.Write("open.off", solid.Off());
  const Outcome made = Run("mesh open.off --json -o m.node");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.err.find("nothing is enclosed, so the whole box is written: no closed surface; "
                          "polygons with a free edge: "),
            std::string::npos)
      << made.err;
  EXPECT_EQ(Value(made.out, "hash"), Value(Run("mesh open.off --surroundings --json").out, "hash"));
  EXPECT_EQ(Run("mesh open.off --inside").code, 2);
}

TEST_F(PrepareCommand, HolesAreToldAndFilledOnRequest) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 2, 3});
  folder_.Write("closed.off", solid.Off());
  solid.faces.erase(solid.faces.begin() + 2, solid.faces.begin() + 4);
  folder_.Write("open.off", solid.Off());
  const Outcome open = Run("mesh open.off --json -o m.node");
  ASSERT_EQ(open.code, 0) << open.err;
  EXPECT_NE(
      open.err.find("open.off: 1 loop of edges with one face: 4 edges, 6 long, round (0.5, 1, "
                    "3). --fill-holes LENGTH fills those up to LENGTH"),
      std::string::npos)
      << open.err;
  EXPECT_EQ(Value(open.out, "open_loops"), "1");
  EXPECT_NE(open.out.find("\"shortest_loops\": [{\"edges\": 4, \"length\": 6,"), std::string::npos)
      << open.out;
  const Outcome less = Run("mesh open.off --json -o m.node --fill-holes 5.9");
  EXPECT_EQ(Value(less.out, "hash"), Value(open.out, "hash"));
  const Outcome filled = Run("mesh open.off --json -o m.node --fill-holes 6");
  ASSERT_EQ(filled.code, 0) << filled.err;
  EXPECT_EQ(Value(filled.out, "hole_filled"), "1") << filled.out;
  EXPECT_EQ(Value(filled.out, "open_edges"), "0");
  const Outcome closed = Run("mesh closed.off --json -o c.node");
  EXPECT_EQ(Value(filled.out, "vertices"), Value(closed.out, "vertices"));
  EXPECT_EQ(Value(filled.out, "simplices"), Value(closed.out, "simplices"));
  EXPECT_EQ(Run("verify m.node --input open.off --fill-holes 6").code, 0);
  EXPECT_EQ(Run("mesh open.off --fill-holes 0").code, 2);
  EXPECT_EQ(Run("mesh open.off --fill-holes 6 --exact").code, 2);
}

TEST_F(PrepareCommand, WhatAMeshRefusesIsMended) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1});
  solid.Add(BoxSolid({0.3, 0.4, 0.5}, {1.5, 1.6, 1.7}));
  folder_.Write("boxes.off", solid.Off());
  const Outcome refused = Run("mesh boxes.off --exact");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("the command without --exact mends"), std::string::npos)
      << refused.err;
  const Outcome made = Run("mesh boxes.off --json -o m.node");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.err.find("boxes.off: mended: "), std::string::npos) << made.err;
  EXPECT_EQ(Value(made.out, "mended"), "true");
  EXPECT_LE(std::stod(Value(made.out, "farthest")), std::stod(Value(made.out, "within")));
  EXPECT_EQ(Run("verify m.node --input boxes.off").code, 0);
  folder_.Write("crack.off", CrackedBox(1e-6).Off());
  const Outcome closed = Run("mesh crack.off --json");
  EXPECT_EQ(Value(closed.out, "open_edges_read"), "8");
  EXPECT_EQ(Value(closed.out, "open_edges"), "0");
  EXPECT_EQ(Run("mesh crack.off --within 0").code, 2);
  EXPECT_NE(Run("mesh crack.off --within 0").err.find("--within"), std::string::npos);
  // A crack that stays takes millions of vertices.
  EXPECT_EQ(Run("mesh crack.off --within 1e-7 --json").code, 1);
}

TEST_F(PrepareCommand, ARefusalThatMendingDoesNotHelpIsThatOfTheInput) {
  // A fold of 0.04 degrees.
  folder_.Write("s.off",
                "OFF\n6 3 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n4 1.5 0.001\n0 1.5 0.001\n"
                "4 0 1 2 3\n3 0 1 4\n3 0 4 5\n");
  const Outcome refused = Run("mesh s.off");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("s.off:"), std::string::npos);
  EXPECT_NE(refused.err.find("does not help; --within allows more"), std::string::npos)
      << refused.err;
}

TEST_F(PrepareCommand, OfAMapItsPolygonsAreWritten) {
  folder_.Write("m.geojson",
                R"({"type": "Polygon", "coordinates": [[[0,0],[4,0],[4,4],[0,4],[0,0]],)"
                R"( [[1,1],[2,1],[2,2],[1,2],[1,1]]]})");
  const std::string hash = Value(Run("mesh m.geojson --json -o m.node").out, "hash");
  EXPECT_EQ(Run("verify m.node --input m.geojson").code, 0);
  EXPECT_EQ(Value(Run("mesh m.geojson --polygons --inside --json").out, "hash"), hash);
  const Outcome segments = Run("mesh m.geojson --segments --json -o s.node");
  EXPECT_EQ(segments.code, 0) << segments.err;
  EXPECT_EQ(Run("verify s.node --input m.geojson --segments").code, 0);
  EXPECT_NE(Value(segments.out, "hash"), hash);
  EXPECT_NE(Value(Run("mesh m.geojson --surroundings --json").out, "hash"), hash);
}

}  // namespace
}  // namespace dynmesh::cli
