// `dynmesh import` of surfaces.
#include <string>

#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

class ImportSurface : public CommandLineFixture {
 protected:
  // Two triangles that cross, one of them twice, and one without area.
  void WriteStl() const {
    std::string text = "solid\n";
    for (const char* triangle : {"vertex 0 0 0\nvertex 4 0 0\nvertex 0 4 0\n",
                                 "vertex 1 1 -1\nvertex 1 1 1\nvertex 1 -3 0\n",
                                 "vertex 0 4 0\nvertex 4 0 0\nvertex 0 0 0\n",
                                 "vertex 9 0 0\nvertex 9 0 0\nvertex 9 1 0\n"}) {
      text += std::string("facet normal 0 0 0\nouter loop\n") + triangle + "endloop\nendfacet\n";
    }
    folder_.Write("soup.stl", text + "endsolid\n");
  }
};

TEST_F(ImportSurface, WhatIsCleanedMeshesInEveryFormat) {
  WriteStl();
  EXPECT_EQ(Run("mesh soup.stl").code, 2);
  EXPECT_EQ(Run("import soup.stl -o plain.off").code, 2);  // an error of the reader
  std::string hash;
  for (const std::string out : {"a.poly", "a.smesh", "a.off", "a.dynmesh"}) {
    const Outcome outcome = Run("import soup.stl --clean --json -o " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const std::vector<std::string> lines = Lines(outcome.out);
    const std::string& summary = lines.back();
    EXPECT_EQ(Value(summary, "summary"), "true");
    EXPECT_EQ(Value(summary, "polygons_read"), "4");
    EXPECT_EQ(Value(summary, "face_doubled"), "1");
    EXPECT_EQ(Value(summary, "face_dropped"), "2");
    EXPECT_EQ(Value(summary, "face_crossed"), "2");
    EXPECT_EQ(Value(summary, "refused"), "0");
    EXPECT_EQ(Value(summary, "changes"), std::to_string(lines.size() - 1));
    EXPECT_NE(lines[0].find("{\"change\": \"face doubled\", \"ids\": ["), std::string::npos);
    const Outcome mesh = Run("mesh --json " + out);
    ASSERT_EQ(mesh.code, 0) << mesh.err;
    if (!hash.empty() && out != "a.dynmesh") {
      EXPECT_EQ(Value(mesh.out, "hash"), hash);
    }
    hash = Value(mesh.out, "hash");
  }
}

TEST_F(ImportSurface, PartsKeepMarkersAndNames) {
  folder_.Write("plates.dynmesh",
                "mesh dim=3 box=-1,-4,-2,5,5,2\n"
                "add point 1 0 0 0\nadd point 2 4 0 0\nadd point 3 0 4 0\n"
                "add point 4 1 1 -1\nadd point 5 1 1 1\nadd point 6 1 -3 0\n"
                "add polygon 7 1 2 3\nadd polygon 8 4 5 6\ncommit\n"
                "marker 7 70\nmarker 8 80\nname 8 fin\n");
  ASSERT_EQ(Run("import plates.dynmesh --clean -o out.dynmesh").code, 0);
  const std::string script = folder_.Read("out.dynmesh");
  std::size_t seventies = 0, eighties = 0, fins = 0, polygons = 0;
  for (const std::string& line : Lines(script)) {
    polygons += line.starts_with("add polygon") ? 1 : 0;
    seventies += line.starts_with("marker") && line.ends_with(" 70") ? 1 : 0;
    eighties += line.starts_with("marker") && line.ends_with(" 80") ? 1 : 0;
    fins += line.starts_with("name") && line.ends_with(" fin") ? 1 : 0;
  }
  EXPECT_EQ(seventies + eighties, polygons);
  EXPECT_GT(seventies, 1U);
  EXPECT_GT(eighties, 1U);
  EXPECT_EQ(fins, eighties);
  ASSERT_EQ(Run("import plates.dynmesh --clean -o out.smesh").code, 0);
  EXPECT_NE(folder_.Read("out.smesh").find(" 80\n"), std::string::npos);
}

TEST_F(ImportSurface, WhatAMeshStillRefusesIsCounted) {
  // Two sheets that meet at 0.6 degrees.
  folder_.Write("wedge.off", "OFF\n4 2 0\n0 0 0\n0 1 0\n1 0.5 0\n1 0.5 0.01\n3 0 1 2\n3 0 1 3\n");
  const Outcome outcome = Run("import wedge.off --clean -o out.off");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("refused by a mesh  1 (SMALL_INPUT_ANGLE 1)"), std::string::npos)
      << outcome.out;
  EXPECT_EQ(folder_.Read("out.off"),
            "OFF\n4 2 0\n0 0 0\n0 1 0\n1 0.5 0\n1 0.5 0.01\n3 0 1 2\n3 0 1 3\n");
}

TEST_F(ImportSurface, WithoutCleaningNothingChanges) {
  folder_.Write("a.off", "OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n4 0 1 2 3\n3 0 1 4\n");
  ASSERT_EQ(Run("import a.off -o b.poly").code, 0);
  ASSERT_EQ(Run("import b.poly -o c.smesh").code, 0);
  ASSERT_EQ(Run("import c.smesh -o d.off").code, 0);
  EXPECT_EQ(folder_.Read("d.off"), folder_.Read("a.off"));
}

TEST_F(ImportSurface, WhatCannotBeDoneIsNamed) {
  folder_.Write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n");
  const auto expect = [&](const std::string& arguments, const std::string& message) {
    const Outcome outcome = Run("import a.off " + arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
  };
  expect("-o b.stl", "neither a .poly, .smesh or .off nor a .dynmesh");
  expect("-o b.off --tolerance 1", "--tolerance needs --clean");
  expect("-o b.off --clean --tolerance 1e-15", "must be at least");
  expect("-o b.off --box 0,0,0,0.5,1,1", "is outside --box");
}

}  // namespace
}  // namespace dynmesh::cli
