// mesh --refine, and meshes of other programs as input.
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/io/elements/element_mesh.h"
#include "core/io/meshes/mesh_files.h"
#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"
#include "tests/support/number_rows.h"

namespace dynmesh::cli::refine_test {
namespace {

constexpr char kFrame[] =
    "8 2 0 1\n1 0 0 5\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 .4 .4 0\n6 .6 .4 0\n7 .6 .6 0\n8 .4 .6 0\n"
    "8 1\n1 1 2 11\n2 2 3 12\n3 3 4 13\n4 4 1 14\n5 5 6 20\n6 6 7 20\n7 7 8 20\n8 8 5 20\n"
    "1\n1 .5 .5\n";

class Refine : public CommandLineFixture {
 protected:
  // The mesh m.node is refused with that message.
  void ExpectRefused(const std::string& message) {
    const Outcome refused = Run("mesh m.node -r");
    EXPECT_EQ(refused.code, 2) << message;
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
    EXPECT_EQ(refused.err.find("nan"), std::string::npos) << refused.err;
  }
  io::IndexedMesh Mesh(const std::string& name) const {
    const auto files = io::ReadMeshFiles(folder_.Path(name));
    EXPECT_TRUE(files.ok()) << files.status();
    return files->mesh;
  }
  static double AreaOf(const io::IndexedMesh& mesh, std::size_t i) {
    const auto& t = mesh.triangles[i];
    const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    return ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
  }
  double AreaOf(const std::string& name) const {
    const io::IndexedMesh mesh = Mesh(name);
    double area = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) area += AreaOf(mesh, i);
    return area;
  }
};

TEST_F(Refine, KeepsAGoodMeshAsItIs) {
  folder_.Write("p.poly", kFrame);
  ASSERT_EQ(Run("mesh p.poly --inside --hmax .2 -o m.node -o m.msh -o m.mesh -o m.vtu").code, 0);
  const io::IndexedMesh before = Mesh("m.node");
  for (const std::string input : {"m.node", "m.ele", "m.msh", "m.mesh", "m.vtu"}) {
    const Outcome again = Run("mesh " + input + " --refine -o r.node --json");
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_EQ(Mesh("r.node").vertices.size(), before.vertices.size()) << input;
    EXPECT_EQ(Mesh("r.node").triangles.size(), before.triangles.size()) << input;
    EXPECT_NEAR(AreaOf("r.node"), 0.96, 1e-14) << input;  // the hole stays a hole
  }
}

TEST_F(Refine, ObeysAreasAndKeepsMarkers) {
  folder_.Write("p.poly", kFrame);
  ASSERT_EQ(Run("mesh p.poly --inside --markers input -o m.poly").code, 0);
  const io::IndexedMesh before = Mesh("m.node");
  // The first triangle may have 1/10 of its area, the others any.
  std::string limits = std::to_string(before.triangles.size()) + "\n";
  const double most = AreaOf(before, 0) / 10;
  for (std::size_t i = 0; i < before.triangles.size(); ++i) {
    limits += std::to_string(i + 1) + " " + (i == 0 ? std::to_string(most) : "-1") + "\n";
  }
  folder_.Write("m.area", limits);
  ASSERT_EQ(Run("mesh m.node -r --markers input -o r.node").code, 0);
  const io::IndexedMesh after = Mesh("r.node");
  EXPECT_GT(after.triangles.size(), before.triangles.size());
  const auto& t = before.triangles[0];
  std::size_t inside = 0;
  for (std::size_t i = 0; i < after.triangles.size(); ++i) {
    double x = 0, y = 0;
    for (const std::uint32_t v : after.triangles[i]) {
      x += after.vertices[v].x / 3, y += after.vertices[v].y / 3;
    }
    bool is_in = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto &p = before.vertices[t[k]], &q = before.vertices[t[(k + 1) % 3]];
      is_in &= (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x) > 0;
    }
    if (!is_in) continue;
    ++inside;
    EXPECT_LE(AreaOf(after, i), most);
  }
  EXPECT_GE(inside, 10U);
  const std::string edges = folder_.Read("r.edge");
  for (const char* marker : {" 11\n", " 12\n", " 13\n", " 14\n", " 20\n"}) {
    EXPECT_NE(edges.find(marker), std::string::npos) << marker;
  }
  folder_.Write("m.area", "1\n1 0.5\n");
  const Outcome refused = Run("mesh m.node -r");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("m.area:1: limits of 1 elements"), std::string::npos) << refused.err;
}

// Markers of vertices, their attributes and those of regions are kept, whatever is in the .poly.
TEST_F(Refine, KeepsWhatFilesSayOfVerticesAndRegions) {
  folder_.Write("p.poly",
                "4 2 1 1\n1 0 0 1 101\n2 1 0 3 0\n3 1 1 0 -3\n4 0 1 -2 14\n4 1\n1 1 2 11\n"
                "2 2 3 12\n3 3 4 13\n4 4 1 14\n0\n1\n1 .5 .5 7.5 .02\n");
  ASSERT_EQ(Run("mesh p.poly --inside --markers input -o m.poly").code, 0);
  ASSERT_EQ(Run("mesh m.node -r -a .004 --markers input -o r.node -o r.msh").code, 0);
  const auto nodes = test::NumberRows(folder_.Read("r.node"));
  ASSERT_GT(nodes.size(), 2 * test::NumberRows(folder_.Read("m.node")).size());
  const std::map<std::pair<double, double>, double> corners = {
      {{0, 0}, 101}, {{1, 0}, 11}, {{1, 1}, -3}, {{0, 1}, 14}};
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const double x = nodes[i][1], y = nodes[i][2];
    const auto corner = corners.find({x, y});
    const double wanted = corner != corners.end() ? corner->second
                          : y == 0                ? 11
                          : x == 1                ? 12
                          : y == 1                ? 13
                          : x == 0                ? 14
                                                  : 0;
    EXPECT_NEAR(nodes[i][3], 1 + 2 * x - 3 * y, 1e-12);
    EXPECT_EQ(nodes[i][4], wanted) << x << " " << y;
  }
  const auto triangles = test::NumberRows(folder_.Read("r.ele"));
  for (std::size_t i = 1; i < triangles.size(); ++i) EXPECT_EQ(triangles[i][4], 7.5);
  // Vertices on a segment are in its group: of points there are only those with other markers.
  const std::string msh = folder_.Read("r.msh");
  const std::string names = msh.substr(0, msh.find("$EndPhysicalNames"));
  EXPECT_NE(names.find("\n0 101 "), std::string::npos) << names;
  EXPECT_EQ(names.find("\n0 13 "), std::string::npos) << names;
}

TEST_F(Refine, NamesTheFileOfWhatIsWrong) {
  const std::string nodes = "4 2 0 0\n1 0 0\n2 1 0\n3 1 1\n4 0 1\n";
  const struct {
    std::string file, text, message;
  } bad[] = {
      {"ele", "2 3 0\n1 1 2 3\n2 1 3 3\n", "m.ele:3: an element has vertex 3 twice"},
      {"ele", "2 3 0\n\n1 1 2 3\n2 1 2 4\n", "m.ele:4: segment "},  // triangles that overlap
      {"edge", "2 1\n1 1 2 5\n2 4 4 5\n", "m.edge:3: an element has vertex 4 twice"},
      {"edge", "2 1\n1 1 2 5\n2 2 4 5\n", "at m.edge:3)"},  // across the diagonal 1-3
      {"area", "2\n1 .1\n2 1e-30\n", "m.area:3: "},
  };
  for (const auto& [file, text, message] : bad) {
    folder_.Write("m.node", nodes);
    folder_.Write("m.ele", "2 3 1\n1 1 2 3 1\n2 1 3 4 2\n");
    folder_.Write("m.edge", "0 1\n");
    folder_.Write("m.area", "2\n1 .1\n2 .1\n");
    folder_.Write("m." + file, text);
    ExpectRefused(message);
  }
}

TEST_F(Refine, NamesTheFileOfWhatIsWrongInSpace) {
  const struct {
    std::string file, text, message;
  } bad[] = {
      {"node", "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1e300\n", "m.node:5: polygon "},
      {"node", "4 3\n1 0 0 0\n2 1e-100 0 0\n3 0 1 0\n4 0 0 1\n", "m.node:3: polygon "},
      {"node", "4 3\n1 0 0 0\n2 1 0 0\n3 2 0 0\n4 3 0 0\n", "m.ele:2: the edge of polygon "},
      {"vol", "1\n1 1e-300\n", "m.vol:2: "},
      {"face", "1 1\n1 1 2 3 5\n2 2 3 4 5\n", "m.face:3: more values"},
  };
  for (const auto& [file, text, message] : bad) {
    folder_.Write("m.node", "4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
    folder_.Write("m.ele", "1 4\n1 1 2 3 4\n");
    folder_.Write("m.face", "0 1\n");
    folder_.Write("m.vol", "1\n1 1\n");
    folder_.Write("m." + file, text);
    ExpectRefused(message);
  }
}

TEST_F(Refine, TakesMeshesOfSpace) {
  folder_.Write("c.off",
                "OFF\n8 12 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n0 0 4\n4 0 4\n4 4 4\n0 4 4\n"
                "3 0 1 2\n3 0 2 3\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n"
                "3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n");
  ASSERT_EQ(Run("mesh c.off --merge-coplanar --inside --hmax 2 -o m.node -o m.vtu").code, 0);
  std::string volumes = std::to_string(Mesh("m.node").tetrahedra.size()) + "\n";
  for (std::size_t i = 0; i < Mesh("m.node").tetrahedra.size(); ++i) {
    volumes += std::to_string(i + 1) + " 0.2\n";
  }
  for (const std::string input : {"m.node", "m.vtu"}) {
    const Outcome again = Run("mesh " + input + " -r -o r.node");
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_GE(Mesh("r.node").tetrahedra.size(), Mesh("m.node").tetrahedra.size() / 2) << input;
  }
  const std::size_t before = Mesh("r.node").tetrahedra.size();
  folder_.Write("m.vol", volumes);
  ASSERT_EQ(Run("mesh m.node -r -o r.node").code, 0);
  EXPECT_GT(Mesh("r.node").tetrahedra.size(), 2 * before);
}

TEST_F(Refine, MeshesAreGeometryWithoutIt) {
  folder_.Write("p.poly", kFrame);
  ASSERT_EQ(Run("mesh p.poly --inside --hmax .2 --markers input -o m.msh").code, 0);
  ASSERT_EQ(Run("mesh m.msh --inside -o g.node").code, 0);
  EXPECT_NEAR(AreaOf("g.node"), 0.96, 1e-14);
  folder_.Write("bad.msh", "$MeshFormat\n4.1 1 8\n");
  const Outcome refused = Run("mesh bad.msh");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("bad.msh:2: the file ends before the number 1"), std::string::npos)
      << refused.err;
}

}  // namespace
}  // namespace dynmesh::cli::refine_test
