// Commands with quadtrees.
#include <string>

#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

constexpr char kScript[] =
    "mesh dim=2 box=0,0,1,1 kind=quadtree\n"
    "add point 1 0.1 0.1\nadd point 2 0.9 0.8\nadd segment 3 1 2\nadd point 4 0.2 0.7\ncommit\n"
    "add point 5 0.2 0.71\ncommit\n"
    "move point 5 0.2 0.8\ncommit\n";

class QuadtreeCommands : public CommandLineFixture {
 protected:
  QuadtreeCommands() { folder_.Write("t.dynmesh", kScript); }
};

TEST_F(QuadtreeCommands, AReplayEndsAsFromScratch) {
  const Outcome replayed = Run("replay t.dynmesh --json --check 1 -o replayed.csv");
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const Outcome made = Run("mesh t.dynmesh --json -o made.csv -o made.vtu -o made.svg");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(Value(made.out, "hash"), Value(Lines(replayed.out)[2], "hash"));
  EXPECT_EQ(folder_.Read("made.csv"), folder_.Read("replayed.csv"));
  EXPECT_EQ(Value(made.out, "leaves"), std::to_string(Lines(folder_.Read("made.csv")).size() - 1));
  const Outcome text = Run("mesh t.dynmesh");
  EXPECT_NE(text.out.find("levels             2 to "), std::string::npos) << text.out;
}

TEST_F(QuadtreeCommands, VerifyAndStatsReadTheLeaves) {
  ASSERT_EQ(Run("mesh t.dynmesh -o t.csv").code, 0);
  Outcome outcome = Run("verify t.csv --input t.dynmesh --json");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  for (const char* check : {"ok", "cells", "cover", "balance", "lfs"}) {
    EXPECT_EQ(Value(outcome.out, check), "true") << check;
  }
  outcome = Run("stats t.csv --lfs t.dynmesh");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("lfs / side"), std::string::npos) << outcome.out;
  // Without one leaf.
  std::string text = folder_.Read("t.csv");
  text.erase(text.rfind('\n', text.size() - 2));
  folder_.Write("bad.csv", text + "\n");
  outcome = Run("verify bad.csv");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.out.find("cover        FAILED"), std::string::npos) << outcome.out;
}

TEST_F(QuadtreeCommands, AFlagChoosesTheKind) {
  folder_.Write("p.node", "4 2 0 0\n1 0 0\n2 4 0\n3 4 3\n4 0.5 0.25\n");
  EXPECT_EQ(Run("mesh p.node --kind quadtree -o p.csv").code, 0);
  EXPECT_EQ(Run("verify p.csv --input p.node").code, 0);
  EXPECT_EQ(Run("mesh t.dynmesh --kind delaunay -o t.node").code, 0);
  EXPECT_EQ(Run("verify t.node --input t.dynmesh").code, 0);
}

TEST_F(QuadtreeCommands, WhatDoesNotFitIsRefusedByName) {
  const std::pair<const char*, const char*> refused[] = {
      {"mesh t.dynmesh --kind octagon", "--kind: a kind of mesh is delaunay, quadtree or triangulation"},
      {"mesh t.dynmesh --rho 2", "--rho: 2 is for meshes of kind delaunay"},
      {"mesh t.dynmesh --hmax 0.1", "--hmax: 0.1 is for meshes of kind delaunay"},
      {"mesh t.dynmesh --criterion thesis", "--criterion: thesis is for meshes"},
      {"mesh t.dynmesh -o t.node", "t.node: a quadtree is written as .csv, .vtu or .svg"},
      {"mesh t.dynmesh --kind delaunay -o t.csv", "t.csv: only the leaves of a quadtree"},
      {"mesh t.dynmesh -o t.svg --fill angle", "--fill: the fill of a quadtree's picture is size"},
      {"mesh t.dynmesh --region 1", "--region, --outside: a quadtree has no simplices"},
      {"verify none.csv", "none.csv"},
      {"lfs t.dynmesh 1,2,3", "a position is X,Y"}};
  for (const auto& [command, message] : refused) {
    const Outcome outcome = Run(command);
    EXPECT_EQ(outcome.code, 2) << command << ": " << outcome.out << outcome.err;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
  }
  folder_.Write("size.dynmesh", "mesh box=0,0,1,1 kind=quadtree\nadd size 9 point 0.5 0.5 0.1\n");
  EXPECT_NE(Run("mesh size.dynmesh").err.find("size.dynmesh:2: feature 9 is a sizing feature"),
            std::string::npos);
}

TEST_F(QuadtreeCommands, LfsOfAnInputIsExact) {
  folder_.Write("p.node", "2 2 0 0\n1 0 0\n2 3 4\n");
  const Outcome outcome = Run("lfs p.node 0,0 3,0 --json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("\"lfs\": [5, 4]"), std::string::npos) << outcome.out;
}

}  // namespace
}  // namespace dynmesh::cli
