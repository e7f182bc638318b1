// Commands with triangulations: no Steiner points, and a judge that knows it.
#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

// A plate with a slit; the sharp corner (8, 0.1) would be refined.
constexpr char kPlate[] =
    "6 2 0 0\n1 0 0\n2 8 0\n3 8 0.1\n4 0 8\n5 1 1\n6 1.5 5\n5 0\n"
    "1 1 2\n2 2 3\n3 3 4\n4 4 1\n5 5 6\n0\n";

class TriangulationCommands : public CommandLineFixture {
 protected:
  TriangulationCommands() { folder_.Write("p.poly", kPlate); }
};

TEST_F(TriangulationCommands, HasThePointsOfTheInputAndIsJudged) {
  const Outcome made = Run("mesh p.poly --no-refine --json -o t.node");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(Value(made.out, "vertices"), std::to_string(24 + 6));  // of the border, of the input
  const Outcome refined = Run("mesh p.poly --json");
  EXPECT_NE(Value(refined.out, "hash"), Value(made.out, "hash"));
  Outcome judged = Run("verify t.node --input p.poly --json");
  EXPECT_EQ(judged.code, 0) << judged.out << judged.err;
  EXPECT_EQ(Value(judged.out, "delaunay"), "true");
  EXPECT_EQ(judged.out.find("\"quality\""), std::string::npos) << judged.out;
  EXPECT_EQ(Run("verify t.node --rho 1.5").code, 1);  // asked for
  // A file that does not say what it is.
  std::string text = folder_.Read("t.node");
  const std::string note = "# dynmesh kind triangulation\n";
  ASSERT_NE(text.find(note), std::string::npos);
  text.erase(text.find(note), note.size());
  folder_.Write("t.node", text);
  EXPECT_EQ(Run("verify t.node").code, 1);
  EXPECT_EQ(Run("verify t.node --no-refine").code, 0);
}

TEST_F(TriangulationCommands, AnEdgeThatIsNotDelaunayIsFound) {
  folder_.Write("q.node",
                "4 2 0 1\n1 0 0 1\n2 3 -1 1\n3 6 0 1\n4 3 1 1\n# dynmesh part\n"
                "# dynmesh kind triangulation\n# dynmesh hash 00000000000000000000000000000000\n");
  folder_.Write("q.ele", "2 3 0\n1 1 2 3\n2 1 3 4\n");
  folder_.Write("q.edge", "5 1\n1 1 2 -1\n2 2 3 -1\n3 3 4 -1\n4 4 1 -1\n5 1 3 0\n");
  EXPECT_NE(Run("verify q.node").out.find("delaunay     FAILED, 1"), std::string::npos)
      << Run("verify q.node").out;
  folder_.Write("q.edge", "5 1\n1 1 2 -1\n2 2 3 -1\n3 3 4 -1\n4 4 1 -1\n5 1 3 7\n");
  EXPECT_NE(Run("verify q.node").out.find("delaunay     ok"), std::string::npos)
      << Run("verify q.node").out;
}

TEST_F(TriangulationCommands, ScriptsFlagsAndWordsMeanTheSame) {
  const std::string edits =
      "add point 1 0.1 0.1\nadd point 2 0.9 0.8\nadd segment 3 1 2\nadd point 4 0.2 0.7\ncommit\n"
      "add point 5 0.2 0.71\ncommit\nmove point 5 0.2 0.8\nremove 3\ncommit\n";
  folder_.Write("kind.dynmesh", "mesh dim=2 box=0,0,1,1 kind=triangulation\n" + edits);
  folder_.Write("none.dynmesh", "mesh dim=2 box=0,0,1,1 quality=none\n" + edits);
  folder_.Write("plain.dynmesh", "mesh dim=2 box=0,0,1,1\n" + edits);
  const Outcome replayed = Run("replay kind.dynmesh --json --check 1");
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const std::string hash = Value(Lines(replayed.out)[2], "hash");
  for (const char* command : {"mesh none.dynmesh --json", "mesh plain.dynmesh --no-refine --json",
                              "mesh plain.dynmesh --kind triangulation --json"}) {
    EXPECT_EQ(Value(Run(command).out, "hash"), hash) << command;
  }
}

TEST_F(TriangulationCommands, WhatDoesNotFitIsRefusedByName) {
  folder_.Write("cube.node", "2 3 0 0\n1 0 0 0\n2 1 1 1\n");
  folder_.Write("size.dynmesh",
                "mesh box=0,0,1,1 kind=triangulation\nadd size 9 point 0.5 0.5 0.1\n");
  folder_.Write("bad.dynmesh", "mesh box=0,0,1,1 quality=2\n");
  const std::pair<const char*, const char*> refused[] = {
      {"mesh p.poly --no-refine --rho 2", "--rho: 2 is for meshes of kind delaunay"},
      {"mesh p.poly --no-refine --hmax 1", "--hmax: 1 is for meshes of kind delaunay"},
      {"mesh p.poly --no-refine --kind quadtree", "--no-refine: is --kind triangulation"},
      {"mesh p.poly --no-refine --engine svr", "--engine: svr"},
      {"mesh p.poly --no-refine --unsplit all", "is marked unsplit in a triangulation"},
      {"mesh cube.node --no-refine", "--no-refine: triangulation is for meshes of dimension 2"},
      {"mesh size.dynmesh", "size.dynmesh:2: feature 9 is a sizing feature"},
      {"mesh bad.dynmesh", "bad.dynmesh:1: quality can only be none"}};
  for (const auto& [command, message] : refused) {
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.code, 2) << command << ": " << outcome.out << outcome.err;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << command << ": " << outcome.err;
  }
}

}  // namespace
}  // namespace dynmesh::cli
