// --inside: what closed outlines and surfaces enclose.
#include <cmath>
#include <filesystem>
#include <string>

#include "core/io/meshes/mesh_files.h"
#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli::selection_test {
namespace {

// A unit square with a square room in it, by segments.
constexpr char kFrame[] =
    "8 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n5 .4 .4\n6 .6 .4\n7 .6 .6\n8 .4 .6\n"
    "8 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n5 5 6\n6 6 7\n7 7 8\n8 8 5\n";

// A cube of side 4 with a cube of side 2 in it, as a .smesh of quadrilaterals.
constexpr char kShell[] =
    "16 3 0 0\n"
    "1 0 0 0\n2 4 0 0\n3 4 4 0\n4 0 4 0\n5 0 0 4\n6 4 0 4\n7 4 4 4\n8 0 4 4\n"
    "9 1 1 1\n10 3 1 1\n11 3 3 1\n12 1 3 1\n13 1 1 3\n14 3 1 3\n15 3 3 3\n16 1 3 3\n"
    "12 0\n"
    "4 1 2 3 4\n4 5 6 7 8\n4 1 2 6 5\n4 2 3 7 6\n4 3 4 8 7\n4 4 1 5 8\n"
    "4 9 10 11 12\n4 13 14 15 16\n4 9 10 14 13\n4 10 11 15 14\n4 11 12 16 15\n4 12 9 13 16\n";

class InsideFlag : public CommandLineFixture {
 protected:
  // The area or volume of a mesh file.
  double SizeOf(const std::string& path) const {
    const auto files = io::ReadMeshFiles(folder_.Path(path));
    EXPECT_TRUE(files.ok()) << files.status();
    double sum = 0;
    const io::IndexedMesh& mesh = files->mesh;
    for (const auto& t : mesh.triangles) {
      const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
      sum += ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
    }
    for (const auto& t : mesh.tetrahedra) {
      std::array<std::array<double, 3>, 3> e;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto p = mesh.vertices[t[0]].position(), q = mesh.vertices[t[k + 1]].position();
        for (std::size_t i = 0; i < 3; ++i) e[k][i] = q[i] - p[i];
      }
      sum += (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
              e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
              e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
             6;
    }
    return sum;
  }
};

TEST_F(InsideFlag, CarvesTheOutsideAndTheHolesAsTriangleDoes) {
  folder_.Write("hole.poly", std::string(kFrame) + "1\n1 .5 .5\n");
  folder_.Write("room.poly", std::string(kFrame) + "0\n");
  ASSERT_EQ(Run("mesh hole.poly --inside -o h.node").code, 0);
  EXPECT_NEAR(SizeOf("h.node"), 0.96, 1e-14);
  EXPECT_EQ(folder_.Read("h.edge").find(" -1\n"), std::string::npos);  // nothing of the box
  // Without a place in it the room stays.
  ASSERT_EQ(Run("mesh room.poly --inside -o r.node").code, 0);
  EXPECT_NEAR(SizeOf("r.node"), 1, 1e-14);
  // A region's seed changes nothing of that.
  folder_.Write("region.poly", std::string(kFrame) + "1\n1 .5 .5\n1\n1 .1 .1 3\n");
  ASSERT_EQ(Run("mesh region.poly --inside -o g.node").code, 0);
  EXPECT_NEAR(SizeOf("g.node"), 0.96, 1e-14);
  // Only the outside of the hole is kept by --outside.
  ASSERT_EQ(Run("mesh room.poly --region any --inside -o n.node").code, 2);
}

TEST_F(InsideFlag, KeepsLinesThatEndInside) {
  folder_.Write("crack.poly",
                "6 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n5 .4 .4\n6 2 2\n"
                "6 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n5 5 1\n6 3 6\n0\n");
  ASSERT_EQ(Run("mesh crack.poly --inside -o c.node").code, 0);
  EXPECT_NEAR(SizeOf("c.node"), 1, 1e-14);
  EXPECT_NE(folder_.Read("c.edge").find(" 11\n"), std::string::npos);  // segment 5
  EXPECT_EQ(folder_.Read("c.edge").find(" 12\n"), std::string::npos);  // the one outside
}

TEST_F(InsideFlag, LeavesOutHolesOfPolygons) {
  folder_.Write("s.dynmesh",
                "mesh box=0,0,4,4\nadd point 1 0 0\nadd point 2 4 0\nadd point 3 4 4\n"
                "add point 4 0 4\nadd point 5 1 1\nadd point 6 2 1\nadd point 7 2 2\n"
                "add point 8 1 2\nadd polygon 9 1 2 3 4 / 5 6 7 8\n");
  ASSERT_EQ(Run("mesh s.dynmesh --inside -o m.node").code, 0);
  EXPECT_NEAR(SizeOf("m.node"), 15, 1e-13);
  ASSERT_EQ(Run("replay s.dynmesh --inside -o r.node").code, 0);
  EXPECT_EQ(folder_.Read("m.ele"), folder_.Read("r.ele"));
}

TEST_F(InsideFlag, CarvesInSpaceWithThePlacesOfHoles) {
  folder_.Write("hole.smesh", std::string(kShell) + "1\n1 2 2 2\n0\n");
  folder_.Write("full.smesh", std::string(kShell) + "0\n0\n");
  ASSERT_EQ(Run("mesh hole.smesh --inside -o h.node").code, 0);
  EXPECT_NEAR(SizeOf("h.node"), 56, 1e-12);
  ASSERT_EQ(Run("mesh full.smesh --inside -o f.node").code, 0);
  EXPECT_NEAR(SizeOf("f.node"), 64, 1e-12);
  // Only the hole is left out.
  ASSERT_EQ(Run("mesh hole.smesh --outside holes -o o.node").code, 0);
  ASSERT_EQ(Run("mesh hole.smesh -o all.node").code, 0);
  EXPECT_NEAR(SizeOf("all.node") - SizeOf("o.node"), 8, 1e-9);
}

TEST_F(InsideFlag, InSpaceAPlaceOnAFacetIsAnErrorOneOutsideIsAWarning) {
  folder_.Write("on.smesh", std::string(kShell) + "1\n1 1 2 2\n0\n");
  Outcome outcome = Run("mesh on.smesh --inside -o m.node");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("on.smesh:32: the place of a hole is on a facet"), std::string::npos)
      << outcome.err;
  folder_.Write("out.smesh", std::string(kShell) + "1\n1 -3 2 2\n0\n");
  outcome = Run("mesh out.smesh --inside -o m.node");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("out.smesh:32: the place of a hole is outside everything"),
            std::string::npos)
      << outcome.err;
}

TEST_F(InsideFlag, SaysWhyNothingIsEnclosed) {
  folder_.Write("open.poly", "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n3 0\n1 1 2\n2 2 3\n3 3 4\n0\n");
  Outcome outcome = Run("mesh open.poly --inside -o m.node");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("--inside: no closed outline; points with one segment: 1, 4 (the "
                             "first at open.poly:2)"),
            std::string::npos)
      << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("m.node")));
  folder_.Write("all.poly", std::string(kFrame) + "2\n1 .5 .5\n2 .1 .1\n");
  outcome = Run("mesh all.poly --inside -o m.node");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("each of the 2 enclosed part(s) is a hole"), std::string::npos)
      << outcome.err;
  folder_.Write("open.smesh",
                "4 3 0 0\n1 0 0 0\n2 4 0 0\n3 4 4 0\n4 0 4 0\n1 0\n4 1 2 3 4\n0\n0\n");
  outcome = Run("mesh open.smesh --inside -o m.node");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("no closed surface; polygons with a free edge: 5"), std::string::npos)
      << outcome.err;
}

TEST_F(InsideFlag, IsOfNoQuadtree) {
  folder_.Write("p.poly", std::string(kFrame) + "0\n");
  EXPECT_EQ(Run("mesh p.poly --kind quadtree --inside -o m.csv").code, 2);
}

}  // namespace
}  // namespace dynmesh::cli::selection_test
