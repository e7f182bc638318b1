// --size, --size-of, --grade, and other words for bounds.
#include <cmath>
#include <string>

#include "core/io/meshes/mesh_files.h"
#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

class SizeFlagsOf : public CommandLineFixture {
 protected:
  void SetUp() override {
    folder_.Write("p.poly",
                  "4 2 0 0\n1 0 0\n2 8 0\n3 8 8\n4 0 8\n4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n");
  }
  io::IndexedMesh Make(const std::string& flags) const {
    const Outcome outcome = Run("mesh p.poly --inside -o m.node " + flags);
    EXPECT_EQ(outcome.code, 0) << flags << outcome.err;
    return io::ReadMeshFiles(folder_.Path("m.node"))->mesh;
  }
  // No edge with an end that `holds` for is longer than sqrt 2 times `h`.
  template <class F>
  static void ExpectAtMost(const io::IndexedMesh& mesh, double h, F holds) {
    std::size_t found = 0;
    for (const auto& e : mesh.edges) {
      const auto &a = mesh.vertices[e.a], &b = mesh.vertices[e.b];
      if (!holds(a) && !holds(b)) continue;
      ++found;
      EXPECT_LE(std::hypot(a.x - b.x, a.y - b.y), std::sqrt(2) * h * (1 + 1e-12));
    }
    EXPECT_GT(found, 0U);
  }
};

TEST_F(SizeFlagsOf, LengthsAreOfSegmentsAndPoints) {
  const std::size_t plain = Make("").vertices.size();
  const io::IndexedMesh mesh = Make("--size-of 5=0.25 --size-of 3,4=.125");
  EXPECT_GT(mesh.vertices.size(), 2 * plain);
  ExpectAtMost(mesh, .25, [](const auto& v) { return v.y == 0; });
  ExpectAtMost(mesh, .125, [](const auto& v) { return v.owner == 3 || v.owner == 4; });
  EXPECT_LT(mesh.vertices.size(), Make("--size-of all=.25").vertices.size());
}

TEST_F(SizeFlagsOf, GradesGrowWithTheDistance) {
  const io::IndexedMesh mesh = Make("--grade 5=.1,1,.5,4");
  ExpectAtMost(mesh, .1, [](const auto& v) { return v.y <= .5; });
  for (const double y : {1.0, 2.0, 3.0}) {
    const double h = .1 + (y - .5) / 3.5 * .9;
    ExpectAtMost(mesh, h, [&](const auto& v) { return v.y <= y; });
  }
  EXPECT_LT(mesh.vertices.size(), Make("--hmax .1").vertices.size() / 3);
}

TEST_F(SizeFlagsOf, FilesAreRead) {
  folder_.Write("a.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 4\n.25 1\n");
  ExpectAtMost(Make("--size a.asc"), .25, [](const auto& v) { return v.x < 4 && v.y < 4; });
  folder_.Write("p.mtr", "4 1\n.1\n0\n0\n0\n");
  ExpectAtMost(Make("--size p.mtr"), .1, [](const auto& v) { return v.owner == 1; });
  folder_.Write("v.pos", "View \"h\" { ST(0,0,0,8,0,0,8,8,0){.5,.5,.5}; };\n");
  ExpectAtMost(Make("--size v.pos"), .5, [](const auto& v) { return v.y < v.x; });
}

TEST_F(SizeFlagsOf, OtherWordsForBoundsMeanTheSame) {
  const io::IndexedMesh area = Make("-a .1 -q 30");
  for (const auto& t : area.triangles) {
    const auto &a = area.vertices[t[0]], &b = area.vertices[t[1]], &c = area.vertices[t[2]];
    EXPECT_LE(((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2, .1);
  }
  EXPECT_GE(std::stod(Value(Run("stats m.node --json").out, "min_angle_deg")), 30 - 1e-6);
  EXPECT_EQ(Value(Run("mesh p.poly --json --min-angle 30").out, "hash"),
            Value(Run("mesh p.poly --json --rho 1.0000000000000002").out, "hash"));
}

TEST_F(SizeFlagsOf, BadOnesAreRefused) {
  folder_.Write("s.smesh", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n0 0\n0\n0\n");
  for (const char* flags :
       {"--size-of 5", "--size-of 5=0", "--size-of 5=x", "--size-of 99=1", "--size-of =1",
        "--grade 5=1,2,3", "--grade 5=2,1,0,1", "--grade 5=1,2,3,2", "--size none.asc",
        "--size p.poly", "--min-angle 31", "--min-angle 0", "-q 20 --rho 1", "-a 1 --hmax 1",
        "--max-area 0", "--max-volume 1"}) {
    const Outcome outcome = Run(std::string("mesh p.poly ") + flags);
    EXPECT_EQ(outcome.code, 2) << flags;
    EXPECT_NE(outcome.err.find("--"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(Run("mesh s.smesh --max-area 1").code, 2);
  EXPECT_EQ(Run("mesh s.smesh --min-angle 20").code, 2);
  EXPECT_EQ(Run("mesh s.smesh --max-volume .01").code, 0);
  // A feature that cannot be names its flag.
  const Outcome outside = Run("mesh p.poly --size-of all=1e-9");
  EXPECT_NE(outside.code, 0);
  EXPECT_NE(outside.err.find("--size-of all=1e-9"), std::string::npos) << outside.err;
}

}  // namespace
}  // namespace dynmesh::cli
