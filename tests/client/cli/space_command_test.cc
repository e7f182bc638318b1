// Commands that take meshes and input of space.
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "client/cli/input.h"
#include "core/io/file_writer.h"
#include "core/io/mesh_files.h"
#include "tests/client/cli/command_line.h"
#include "tests/core/io/good_space_mesh.h"

namespace dynmesh::cli {
namespace {

using testing::GoodSpaceMesh;

class SpaceCommands : public CommandLineFixture {
 protected:
  // m.node and so on, a mesh of what is in input.poly.
  void WriteMeshAndInput() {
    GoodSpaceMesh good = testing::MakeGoodSpaceMesh(4, 0);
    // A file numbers points, segments and polygons in this order.
    std::map<FeatureId, FeatureId> number = {{kNoFeature, kNoFeature}, {kBoxFeature, kBoxFeature}};
    std::string nodes, facets;
    for (const FeatureKind kind :
         {FeatureKind::kPoint, FeatureKind::kSegment, FeatureKind::kPolygon}) {
      for (const Feature& f : good.features) {
        if (f.kind != kind) continue;
        const FeatureId id = number.size() - 1;
        number[f.id] = id;
        if (kind == FeatureKind::kPoint) {
          nodes += std::to_string(id);
          for (const double c : f.position) nodes += " " + io::FormatDouble(c);
          nodes += "\n";
        } else if (kind == FeatureKind::kSegment) {
          facets += "1\n2 " + std::to_string(number[f.ends[0]]) + " " +
                    std::to_string(number[f.ends[1]]) + "\n";
        } else {
          facets += std::to_string(f.rings.size()) + " 1\n";
          for (const auto& ring : f.rings) {
            facets += std::to_string(ring.size());
            for (const FeatureId corner : ring) facets += " " + std::to_string(number[corner]);
            facets += "\n";
          }
          facets += "1 4 4 4\n";  // the hole
        }
      }
    }
    folder_.Write("input.poly", "10 3 0 0\n" + nodes + "3 0\n" + facets + "0\n0\n");
    for (auto* owners :
         {&good.mesh.vertices.owners, &good.mesh.subsegments.owners, &good.mesh.subfacets.owners}) {
      for (FeatureId& owner : *owners) owner = number.at(owner);
    }
    const io::IndexedMesh mesh = io::IndexMesh(good.mesh).value();
    ASSERT_TRUE(io::WriteMeshFiles(mesh, folder_.Path("m")).ok());
  }
};

TEST_F(SpaceCommands, VerifyJudgesAMeshByItsInput) {
  WriteMeshAndInput();
  Outcome outcome = Run("verify m.node --input input.poly --rho 100");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find(" tetrahedra, "), std::string::npos) << outcome.out;
  outcome = Run("verify m.node --input input.poly --rho 100 --json");
  EXPECT_EQ(outcome.code, 0);
  for (const char* check : {"ok", "faces", "facets", "input", "delaunay", "box"}) {
    EXPECT_EQ(Value(outcome.out, check), "true") << check;
  }
  EXPECT_NE(Value(outcome.out, "subfacets"), "0");
  // A subfacet less.
  std::string faces = folder_.Read("m.face");
  const std::size_t first = faces.find(" 13\n");  // the polygon's marker
  ASSERT_NE(first, std::string::npos);
  faces.replace(first, 4, " -1\n");
  folder_.Write("m.face", faces);
  outcome = Run("verify m.node --input input.poly --rho 100 --json");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(Value(outcome.out, "faces"), "false");
  EXPECT_EQ(Value(outcome.out, "facets"), "false");
  EXPECT_EQ(Value(outcome.out, "input"), "true");
}

TEST_F(SpaceCommands, TellTheDimensionsApart) {
  WriteMeshAndInput();
  folder_.Write("plane.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n");
  folder_.Write("plane.ele", "1 3 0\n1 1 2 3\n");
  EXPECT_EQ(Run("verify m.node --input plane.node").code, 2);
  EXPECT_NE(Run("diff m.node plane.node").code, 0);
  EXPECT_EQ(Run("diff m.node m.node").code, 0);
  EXPECT_NE(Run("diff m.node m.node").out.find("subfacets"), std::string::npos);
  EXPECT_EQ(Run("import input.poly -o out.poly").code, 2);
  EXPECT_EQ(Run("stats m.node").code, 2);
}

TEST_F(SpaceCommands, InputOfSpaceIsReadByExtension) {
  folder_.Write("m.off", "OFF\n4 2 0\n0 0 1\n2 0 1\n2 3 1\n0 3 5\n3 0 1 2\n3 0 2 3\n");
  absl::StatusOr<Input> input = LoadInput(folder_.Path("m.off"));
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->options.dimension, 3);
  EXPECT_EQ(input->options.box, (Box{{0, 0, 1}, {2, 3, 5}}));
  EXPECT_EQ(input->features.size(), 6U);
  EXPECT_TRUE(input->where(6).ends_with("m.off:8")) << input->where(6);
}

TEST_F(SpaceCommands, CoplanarFacesAreMergedOnDemand) {
  folder_.Write("m.off", "OFF\n4 2 0\n0 0 1\n2 0 1\n2 3 1\n0 3 1.001\n3 0 1 2\n3 0 2 3\n");
  const auto count = [&](const InputFlags& flags) {
    const absl::StatusOr<Input> input = LoadInput(folder_.Path("m.off"), flags);
    EXPECT_TRUE(input.ok()) << input.status();
    return std::count_if(input->features.begin(), input->features.end(),
                         [](const Feature& f) { return f.kind == FeatureKind::kPolygon; });
  };
  EXPECT_EQ(count({}), 2);
  EXPECT_EQ(count({true, 0}), 2);
  EXPECT_EQ(count({true, 0.01}), 1);
  EXPECT_NE(Run("verify --help").out.find("--merge-coplanar"), std::string::npos);
  EXPECT_NE(Run("mesh --help").out.find("--merge-coplanar"), std::string::npos);
}

}  // namespace
}  // namespace dynmesh::cli
