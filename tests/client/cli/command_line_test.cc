// The `dynmesh` program from the user's side: arguments, output, exit codes.
#include "tests/client/cli/command_line.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace dynmesh::cli {
namespace {

class CommandLine : public CommandLineFixture {
 protected:
  void WriteInputs() const {
    folder_.Write("square.poly",
                  "5 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n5 0.3 0.4\n"
                  "4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n");
    folder_.Write("edits.txt",
                  "mesh dim=2 box=0,0,1,1 rho=1.4142135623730951\n"
                  "add point 1 0 0\nadd point 2 1 0\nadd point 3 1 1\nadd point 4 0 1\n"
                  "commit\n"
                  "add point 5 0.7 0.8\nadd segment 6 1 2\nadd segment 7 2 3\n"
                  "commit\n"
                  "move point 5 0.3 0.4\nadd segment 8 3 4\nadd segment 9 4 1\nremove 7\n"
                  "commit\n"
                  "add segment 7 2 3\n");
  }
};

TEST_F(CommandLine, VersionEverywhere) {
  for (const char* arguments : {"--version", "mesh --version", "replay --version",
                                "import --version", "verify --version", "diff --version"}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.code, 0) << arguments;
    EXPECT_TRUE(outcome.out.starts_with("dynmesh ")) << outcome.out;
  }
}

TEST_F(CommandLine, HelpNamesTheCommands) {
  const Outcome outcome = Run("--help");
  EXPECT_EQ(outcome.code, 0);
  for (const char* command : {"mesh", "replay", "import", "verify", "diff"}) {
    EXPECT_NE(outcome.out.find(command), std::string::npos);
  }
}

TEST_F(CommandLine, BadUsageAndBadInputAreTwo) {
  WriteInputs();
  folder_.Write("bad.node", "1 2 0 0\n1 0 zero\n");
  folder_.Write("bad.txt", "mesh dim=2 box=0,0,1,1\nadd point 1 2\n");
  folder_.Write("flat.poly", "2 2 0 0\n1 0 0\n2 1 0\n1 0\n1 1 1\n0\n");
  for (const char* arguments : {"",
                                "frob",
                                "mesh",
                                "mesh --frob square.poly",
                                "mesh none.node",
                                "mesh bad.node",
                                "mesh flat.poly",
                                "mesh square.poly --rho 0.5",
                                "mesh square.poly --rho x",
                                "mesh square.poly --criterion best",
                                "mesh square.poly --engine svr --rho 1.2",
                                "replay edits.txt --engine svr",
                                "mesh square.poly --engine steam",
                                "mesh square.poly --box 0,0,1",
                                "mesh square.poly --box 0,0,0.5,0.5",
                                "mesh square.poly -o mesh",
                                "mesh square.poly -o m.png",
                                "mesh square.poly -o m.svg --fill blue",
                                "mesh square.poly -o m.svg --fill change",
                                "mesh square.poly -o m.svg --fill dihedral",
                                "replay edits.txt -o m.svg --fill dihedral",
                                "mesh square.poly -o m.svg --crop 1",
                                "stats none.node",
                                "stats bad.node",
                                "stats square.poly",
                                "stats none.node --rho 0",
                                "stats none.node --svg picture.png",
                                "stats none.node --width 10",
                                "stats plate --svg plate.svg",
                                "stats plate --min-dihedral 10",
                                "stats none.node --min-dihedral 21",
                                "mesh square.stl",
                                "replay",
                                "replay none.txt",
                                "replay bad.txt",
                                "replay square.poly",
                                "replay edits.txt --check -1",
                                "replay edits.txt --check x",
                                "verify",
                                "verify none",
                                "verify none --rho 0",
                                "verify none --min-dihedral -1",
                                "diff none",
                                "diff none none"}) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.err;
    EXPECT_NE(outcome.err, "") << arguments;
    EXPECT_EQ(outcome.out, "") << arguments;
  }
}

TEST_F(CommandLine, ErrorsNameFileAndLine) {
  WriteInputs();
  folder_.Write("bad.node", "1 2 0 0\n1 0 zero\n");
  EXPECT_NE(Run("mesh bad.node").err.find("bad.node:2: "), std::string::npos);
  folder_.Write("twice.txt", "mesh box=0,0,1,1\nadd point 1 .5 .5\ncommit\n\nadd point 1 .6 .6\n");
  EXPECT_NE(Run("replay twice.txt").err.find("twice.txt:5: "), std::string::npos);
  EXPECT_NE(Run("mesh twice.txt").err.find("twice.txt:5: "), std::string::npos);
  // Options named as in the script, or by the flag.
  const auto begins = [this](const std::string& arguments, const std::string& words) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_EQ(outcome.err.find("dynmesh: " + words), 0u) << arguments << ": " << outcome.err;
  };
  folder_.Write("rho.txt", "# a comment\n\nmesh rho=.5 box=0,0,1,1\nadd point 1 .5 .5\n");
  folder_.Write("tiny.txt", "mesh box=0,0,1e-50,1e-50\nadd point 1 0 0\n");
  for (const std::string command : {"mesh ", "replay "}) {
    begins(command + "rho.txt", "rho.txt:3: rho: 0.5 is not in 1 to 100");
    begins(command + "rho.txt --rho 0.25", "--rho: 0.25 is not in 1 to 100");
    begins(command + "rho.txt --rho 1 --max-vertices 2", "--max-vertices: 2 is below");
    begins(command + "tiny.txt", "tiny.txt:1: box: longest side");
    begins(command + "tiny.txt --box 1e100,0,1e100,1", "--box: ");
  }
  // What is missing in an empty file is missing on its first line.
  for (const std::string name : {"empty", "empty.stl", "empty.node", ".stl"}) {
    folder_.Write(name, "");
    begins("mesh " + name, name + ":1: ");
  }
  // A file without geometry is none: it would make a mesh of nothing.
  folder_.Write("words.obj", "hello world\n");
  folder_.Write("none.poly", "0 2 0 0\n0 0\n0\n");
  folder_.Write("none.node", "0 2 0 0\n");
  folder_.Write("none.geojson", "{\"type\": \"FeatureCollection\", \"features\": []}\n");
  for (const std::string name : {"words.obj", "none.poly", "none.node", "none.geojson"}) {
    begins("mesh " + name, name + ":1: the file has no points, segments or polygons");
  }
  folder_.Write("picture.svg", "<svg/>");
  begins("mesh picture.svg", "picture.svg: .svg files as input are not supported");
  folder_.Write("h.npy", "");
  begins("mesh h.npy", "h.npy: .npy files have target lengths: give it with --size");
  folder_.Write("cross.poly", "4 2 0 0\n1 0 0\n2 1 1\n3 1 0\n4 0 1\n2 0\n1 1 2\n2 3 4\n0\n");
  const Outcome cross = Run("mesh cross.poly --exact");
  EXPECT_EQ(cross.code, 2);
  EXPECT_NE(cross.err.find("the command without --exact mends"), std::string::npos)
      << cross.err;
  EXPECT_TRUE(cross.err.find("cross.poly:7") != std::string::npos ||
              cross.err.find("cross.poly:8") != std::string::npos)
      << cross.err;
}

TEST_F(CommandLine, MeshPrintsItsMeasures) {
  WriteInputs();
  const Outcome outcome = Run("mesh square.poly --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  ASSERT_EQ(Lines(outcome.out).size(), 1U);
  for (const char* key : {"vertices", "simplices", "worst_radius_edge", "min_angle_deg", "over_rho",
                          "exempt", "build_seconds", "hash"}) {
    EXPECT_NE(Value(outcome.out, key), "") << key;
  }
  EXPECT_EQ(Value(outcome.out, "over_rho"), "0");
  EXPECT_GE(std::stod(Value(outcome.out, "min_angle_deg")), 20.7);
  EXPECT_EQ(Value(outcome.out, "hash").size(), 34U);  // with its quotes
}

TEST_F(CommandLine, MeshFilesPassVerification) {
  WriteInputs();
  ASSERT_EQ(Run("mesh square.poly -o m.node -o m.vtu -o m.svg").code, 0);
  const Outcome good = Run("verify m.node --input square.poly");
  EXPECT_EQ(good.code, 0) << good.out;
  const Outcome json = Run("verify m --input square.poly --json");
  EXPECT_EQ(json.code, 0);
  EXPECT_EQ(Value(json.out, "ok"), "true");
  EXPECT_EQ(Value(json.out, "input"), "true");
  EXPECT_TRUE(folder_.Read("m.vtu").starts_with("<?xml"));
  EXPECT_TRUE(folder_.Read("m.svg").starts_with("<svg"));
}

TEST_F(CommandLine, WritesEveryFormatByExtension) {
  WriteInputs();
  ASSERT_EQ(Run("mesh square.poly -o m.msh -o m.mesh -o m.vtu").code, 0);
  EXPECT_TRUE(folder_.Read("m.msh").starts_with("$MeshFormat\n4.1 0 8\n"));
  EXPECT_TRUE(folder_.Read("m.mesh").starts_with("MeshVersionFormatted 2\n"));
  for (const char* name : {"quality", "min_angle", "exempt"}) {
    EXPECT_NE(folder_.Read("m.vtu").find(std::string("Name=\"") + name + "\""), std::string::npos);
  }
  // The last batch of the script adds a segment; by then all else is as in the static run.
  ASSERT_EQ(Run("replay edits.txt -o dynamic.msh -o dynamic.mesh").code, 0);
  ASSERT_EQ(Run("mesh edits.txt -o static.msh -o static.mesh").code, 0);
  EXPECT_EQ(folder_.Read("dynamic.msh"), folder_.Read("static.msh"));
  EXPECT_EQ(folder_.Read("dynamic.mesh"), folder_.Read("static.mesh"));
}

TEST_F(CommandLine, PicturesShowWhatTheLastEditChanged) {
  WriteInputs();
  folder_.Write("far.txt",
                "mesh box=0,0,1,1\nadd point 1 .1 .1\nadd point 2 .11 .1\ncommit\n"
                "add point 3 .9 .9\nadd point 4 .91 .9\n");
  const Outcome outcome = Run("replay far.txt --json -o a.svg --fill change");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  ASSERT_EQ(Run("replay far.txt -o b.svg --highlight").code, 0);
  EXPECT_EQ(folder_.Read("a.svg"), folder_.Read("b.svg"));
  const std::string svg = folder_.Read("a.svg");
  const std::size_t at = svg.find("<path fill=\"#f6a821\"");
  ASSERT_NE(at, std::string::npos);
  const std::string drawn = svg.substr(at, svg.find("/>", at) - at);
  EXPECT_EQ(std::to_string(std::count(drawn.begin(), drawn.end(), 'z')),
            Value(Lines(outcome.out)[1], "added_simplices"));
  for (const char* fill : {"angle", "quality", "size", "exempt", "plain", "none"}) {
    EXPECT_EQ(Run(std::string("replay far.txt -o c.svg --fill ") + fill).code, 0) << fill;
  }
}

TEST_F(CommandLine, StatsOfAFileNeedNoServer) {
  WriteInputs();
  const Outcome made = Run("mesh square.poly --json -o m.node");
  ASSERT_EQ(made.code, 0);
  const Outcome json = Run("stats m.node --json --svg h.svg");
  ASSERT_EQ(json.code, 0) << json.err;
  for (const char* key : {"vertices", "simplices", "subsegments", "worst_radius_edge",
                          "min_angle_deg", "max_angle_deg", "over_rho", "exempt"}) {
    EXPECT_EQ(Value(json.out, key), Value(made.out, key)) << key;
  }
  EXPECT_NE(json.out.find("\"least_angle_histogram\": ["), std::string::npos);
  EXPECT_TRUE(folder_.Read("h.svg").starts_with("<svg "));
  ASSERT_EQ(Run("stats ./m --svg log.svg --log --rho 2").code, 0);
  EXPECT_NE(folder_.Read("log.svg"), folder_.Read("h.svg"));
  EXPECT_NE(Run("stats m.node").out.find("degrees"), std::string::npos);
  EXPECT_EQ(json.out.find("dihedral"), std::string::npos);
  for (const std::string command : {"stats", "verify"}) {
    const Outcome refused = Run(command + " m.node --min-dihedral 10");
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("m.node is 2D"), std::string::npos) << refused.err;
  }
}

TEST_F(CommandLine, TheLocalFeatureSizeIsComparedWithTheMesh) {
  WriteInputs();
  ASSERT_EQ(Run("mesh square.poly -o m.node").code, 0);
  const Outcome verified = Run("verify m.node --input square.poly --lfs --json"),
                counted = Run("stats m.node --lfs square.poly --json");
  for (const Outcome* outcome : {&verified, &counted}) {
    ASSERT_EQ(outcome->code, 0) << outcome->err;
    const std::size_t at = outcome->out.find("\"lfs_over_lms\": {\"min\": ");
    ASSERT_NE(at, std::string::npos) << outcome->out;
    const std::string figures = outcome->out.substr(at);
    const double median = std::stod(Value(figures, "p50")), most = std::stod(Value(figures, "max"));
    EXPECT_GE(median, 0.5);
    EXPECT_GE(most, median);
    EXPECT_LT(most, 20);
  }
  EXPECT_NE(Run("stats m.node --lfs square.poly").out.find("local feature size"),
            std::string::npos);
  EXPECT_EQ(Run("verify m.node --lfs").code, 2);  // of what input?
  EXPECT_EQ(Run("stats m.node --lfs none.poly").code, 2);
}

TEST_F(CommandLine, VerifyFailsOnADamagedFile) {
  WriteInputs();
  ASSERT_EQ(Run("mesh square.poly -o m.node").code, 0);
  std::string edges = folder_.Read("m.edge");
  const std::size_t at = edges.find(" 6\n");  // a subsegment of segment 6
  ASSERT_NE(at, std::string::npos);
  folder_.Write("m.edge", edges.replace(at, 3, " 0\n"));
  const Outcome bad = Run("verify m.node --input square.poly --json");
  EXPECT_EQ(bad.code, 1);
  EXPECT_EQ(Value(bad.out, "ok"), "false");
  EXPECT_EQ(Value(bad.out, "input"), "false");
  EXPECT_EQ(Value(bad.out, "delaunay"), "true");
}

TEST_F(CommandLine, TheOrderOfLinesInAScriptDoesNotShowInTheMesh) {
  WriteInputs();
  folder_.Write("a.txt",
                "mesh box=0,0,1,1\nadd segment 3 1 2\nadd point 2 .9 .8\nadd point 1 .1 .2\n");
  folder_.Write("b.txt",
                "mesh box=0,0,1,1\nadd point 1 .1 .2\nadd point 2 .9 .8\nadd segment 3 1 2\n");
  const Outcome a = Run("mesh a.txt --json -o a.node");
  const Outcome b = Run("mesh b.txt --json -o b.node");
  ASSERT_EQ(a.code, 0) << a.err;
  EXPECT_EQ(Value(a.out, "hash"), Value(b.out, "hash"));
  for (const std::string extension : {".node", ".ele", ".edge"}) {
    EXPECT_EQ(folder_.Read("a" + extension), folder_.Read("b" + extension));
  }
}

TEST_F(CommandLine, ReplayPrintsEveryRevisionAndASummary) {
  WriteInputs();
  const Outcome outcome = Run("replay edits.txt --check 1 --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 5U);
  const char* features[] = {"4", "7", "8", "9"};
  long vertices = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(Value(lines[i], "revision"), std::to_string(i + 1));
    EXPECT_EQ(Value(lines[i], "features"), features[i]);
    for (const char* key : {"simplices", "added_simplices", "removed_simplices", "operations",
                            "created", "dropped", "microseconds", "hash"}) {
      EXPECT_NE(Value(lines[i], key), "") << key;
    }
    const long now = std::stol(Value(lines[i], "vertices"));
    if (i > 0) {
      EXPECT_EQ(now, vertices + std::stol(Value(lines[i], "added_vertices")) -
                         std::stol(Value(lines[i], "removed_vertices")));
    }
    vertices = now;
  }
  EXPECT_EQ(Value(lines[4], "summary"), "true");
  EXPECT_EQ(Value(lines[4], "edits"), "12");
  EXPECT_EQ(Value(lines[4], "revisions"), "4");
  for (const char* key :
       {"p50_microseconds", "p99_microseconds", "trace_bytes", "peak_rss_bytes"}) {
    EXPECT_GT(std::stod(Value(lines[4], key)), 0) << key;
  }
}

TEST_F(CommandLine, ReplayEndsInTheMeshOfTheStaticRun) {
  WriteInputs();
  ASSERT_EQ(Run("replay edits.txt -o dynamic.node").code, 0);
  ASSERT_EQ(Run("mesh edits.txt -o static.node").code, 0);
  const Outcome same = Run("diff dynamic.node static.node --json");
  EXPECT_EQ(same.code, 0) << same.out;
  EXPECT_EQ(Value(same.out, "same"), "true");
  for (const std::string extension : {".node", ".ele", ".edge"}) {
    EXPECT_EQ(folder_.Read("dynamic" + extension), folder_.Read("static" + extension));
  }
  EXPECT_EQ(Run("verify dynamic.node --input edits.txt").code, 0);
}

TEST_F(CommandLine, DiffTellsMeshesApart) {
  WriteInputs();
  ASSERT_EQ(Run("mesh square.poly -o a.node").code, 0);
  ASSERT_EQ(Run("mesh square.poly --box -1,-1,2,2 -o b.node").code, 0);
  const Outcome outcome = Run("diff a b --json");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(Value(outcome.out, "same"), "false");
  EXPECT_GE(std::stol(Value(outcome.out, "vertices_shared")), 5);
  EXPECT_GT(std::stol(Value(outcome.out, "vertices_only_a")), 0);
}

TEST_F(CommandLine, AFullOutputIsAFailure) {
  WriteInputs();
  EXPECT_EQ(Run("mesh square.poly -o no/such/folder/m.node").code, 1);
  const std::string command =
      "'" DYNMESH_BINARY "' mesh '" + folder_.Path("square.poly") + "' > /dev/full 2> /dev/null";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

}  // namespace
}  // namespace dynmesh::cli
