// Commands with 3D meshes and input.
#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "client/cli/input.h"
#include "core/io/common/file_writer.h"
#include "core/io/meshes/mesh_files.h"
#include "tests/client/cli/command_line.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/support/seed.h"

namespace dynmesh::cli {
namespace {

using testing::GoodSpaceMesh;

class SpaceCommands : public CommandLineFixture {
 protected:
  // m.node and so on: a mesh of input.poly.
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

// A box in a box; in the second, the faces of the inner one are cut into triangles.
const std::string kTwoBoxes =
    "0 0 0\n4 0 0\n4 4 0\n0 4 0\n0 0 4\n4 0 4\n4 4 4\n0 4 4\n"
    "1 1 1\n3 1 1\n3 3 1\n1 3 1\n1 1 3\n3 1 3\n3 3 3\n1 3 3\n"
    "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
const std::string kBoxInBox =
    "OFF\n16 12 0\n" + kTwoBoxes +
    "4 8 11 10 9\n4 12 13 14 15\n4 8 9 13 12\n4 9 10 14 13\n4 10 11 15 14\n4 11 8 12 15\n";
const std::string kBoxInTriangles =
    "OFF\n16 18 0\n" + kTwoBoxes +
    "3 8 11 10\n3 8 10 9\n3 12 13 14\n3 12 14 15\n3 8 9 13\n3 8 13 12\n"
    "3 9 10 14\n3 9 14 13\n3 10 11 15\n3 10 15 14\n3 11 8 12\n3 11 12 15\n";

TEST_F(SpaceCommands, AMeshOfSpaceIsMadeJudgedAndMeasured) {
  folder_.Write("box.off", kBoxInTriangles);
  const Outcome uncut = Run("mesh box.off -o uncut.node");
  ASSERT_EQ(uncut.code, 0) << uncut.err;
  EXPECT_EQ(Run("verify uncut.node --input box.off").code, 0);
  for (const std::string merged : {" --merge-coplanar", ""}) {
    SCOPED_TRACE(merged);
    if (merged.empty()) folder_.Write("box.off", kBoxInBox);
    const Outcome made =
        Run("mesh box.off --surroundings --json -o m.node -o m.vtu -o m.msh -o m.mesh -o m.svg" +
            merged);
    ASSERT_EQ(made.code, 0) << made.err;
    EXPECT_LE(std::stod(Value(made.out, "worst_radius_edge")), 2.0);
    EXPECT_GT(std::stod(Value(made.out, "worst_radius_edge")), 1.5);  // rho is 2, not sqrt 2
    const Outcome judged = Run("verify m.node --json --input box.off" + merged);
    EXPECT_EQ(judged.code, 0) << judged.out;
    EXPECT_EQ(Value(judged.out, "rho"), "2");
    EXPECT_EQ(Value(judged.out, "hash"), Value(made.out, "hash"));
    EXPECT_EQ(Value(judged.out, "subfacets"), Value(made.out, "subfacets"));
    const Outcome measured = Run("stats m.node --json --svg h.svg");
    ASSERT_EQ(measured.code, 0) << measured.err;
    for (const char* key : {"simplices", "subfacets", "min_angle_deg", "max_angle_deg"}) {
      EXPECT_EQ(Value(measured.out, key), Value(made.out, key)) << key;
    }
    EXPECT_EQ(Value(measured.out, "rho"), "2");
    EXPECT_LT(std::stod(Value(measured.out, "share_below_10_deg")), 1e-3);
    EXPECT_NE(folder_.Read("h.svg").find("All dihedral angles"), std::string::npos);
  }
  EXPECT_NE(Run("mesh box.off").out.find("tetrahedra"), std::string::npos);
  EXPECT_NE(Run("stats m.node").out.find("slivers"), std::string::npos);
  EXPECT_EQ(Run("mesh box.off --criterion thesis").code, 0);
  EXPECT_EQ(Run("mesh box.off --rho 1.9 --criterion thesis").code, 2);
  EXPECT_EQ(Run("mesh box.off --rho 1.1").code, 2);
  EXPECT_EQ(Run("mesh box.off --box=-1,-1,-1,5,5,5").code, 0);
  EXPECT_EQ(Run("mesh box.off --box=0,0,4,4").code, 2);
}

TEST_F(SpaceCommands, TellOfDihedralAngles) {
  folder_.Write("box.off", kBoxInBox);
  const Outcome made =
      Run("mesh box.off --surroundings --min-dihedral 10 --json -o m.node -o d.svg -o m.vtu "
          "--fill dihedral");
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string below = Value(made.out, "below_dihedral");
  EXPECT_LE(std::stoi(below), 2);
  EXPECT_NE(folder_.Read("d.svg").find(">least dihedral angle, degrees<"), std::string::npos);
  EXPECT_NE(folder_.Read("m.vtu").find("Name=\"min_dihedral\""), std::string::npos);
  Outcome judged = Run("verify m.node --json --input box.off --min-dihedral 10");
  EXPECT_EQ(judged.code, below == "0" ? 0 : 1) << judged.out;
  EXPECT_EQ(Value(judged.out, "below_dihedral"), below);
  EXPECT_NEAR(std::stod(Value(judged.out, "min_dihedral_deg")),
              std::stod(Value(made.out, "min_angle_deg")), 1e-9);
  EXPECT_EQ(Value(Run("stats m.node --json --min-dihedral 10").out, "below_dihedral"), below);
  EXPECT_NE(Run("mesh box.off --min-dihedral 10").out.find("below dihedral "), std::string::npos);

  // Slivers that were not removed.
  const Outcome other = Run("mesh box.off --surroundings --min-dihedral 0 --json -o s.node");
  EXPECT_EQ(Value(other.out, "below_dihedral"), "0");  // without a bound
  const Outcome measured = Run("stats s.node --json --min-dihedral 10");
  ASSERT_EQ(measured.code, 0) << measured.err;
  EXPECT_GT(std::stoi(Value(measured.out, "below_dihedral")), 10);
  EXPECT_NE(measured.out.find("\"worst_dihedral\": [{\"angle_deg\": "), std::string::npos);
  judged = Run("verify s.node --json");
  EXPECT_EQ(judged.code, 0) << judged.out;
  EXPECT_EQ(judged.out.find("below_dihedral"), std::string::npos);
  EXPECT_EQ(judged.out.find("\"dihedral\""), std::string::npos);
  judged = Run("verify s.node --json --min-dihedral 10");
  EXPECT_EQ(judged.code, 1);
  EXPECT_EQ(Value(judged.out, "ok"), "false");
  EXPECT_EQ(Value(judged.out, "dihedral"), "false");
  EXPECT_EQ(Value(judged.out, "below_dihedral"), Value(measured.out, "below_dihedral"));
  EXPECT_NE(judged.out.find(" has a dihedral angle of "), std::string::npos);
  const double least = std::stod(Value(judged.out, "min_dihedral_deg"));
  EXPECT_EQ(Run("verify s.node --min-dihedral " + io::FormatDouble(least - 1e-8)).code, 0);
  EXPECT_EQ(Run("verify s.node --min-dihedral " + io::FormatDouble(least + 1e-8)).code, 1);
}

TEST_F(SpaceCommands, VerifyCountsBelowADihedralAngleAsTheMesherDoes) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> within(0, 1);
  for (const int count : {20, 150, 400}) {
    std::string nodes = std::to_string(count) + " 3 0 0\n";
    for (int i = 1; i <= count; ++i) {
      nodes += std::to_string(i);
      for (int k = 0; k < 3; ++k) nodes += " " + io::FormatDouble(within(random));
      nodes += "\n";
    }
    folder_.Write("points.node", nodes);
    for (const std::string bound : {"5", "10", "20"}) {  // at 20 some remain
      const Outcome made =
          Run("mesh points.node --json -o m.node -o e.svg --fill exempt --min-dihedral " + bound);
      ASSERT_EQ(made.code, 0) << made.err;
      const std::string below = Value(made.out, "below_dihedral");
      for (const std::string asked : {"5", "10", "20"}) {
        const std::string flags = " m.node --json --min-dihedral " + asked;
        const Outcome judged = Run("verify" + flags);
        const std::string counted = Value(judged.out, "below_dihedral");
        EXPECT_EQ(counted, Value(Run("stats" + flags).out, "below_dihedral"));
        EXPECT_EQ(judged.code, counted == "0" ? 0 : 1) << judged.out;
        if (asked == bound) {
          EXPECT_EQ(counted, below);
        }
      }
      EXPECT_NE(folder_.Read("e.svg").find(">dihedral angle below " + bound + " degrees<"),
                std::string::npos);
    }
  }
}

TEST_F(SpaceCommands, PolygonsWantRhoOf1Point4) {
  folder_.Write("box.off", kBoxInBox);
  const Outcome refused = Run("mesh box.off --rho 1.39");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("box.off:19: polygon 17 "), std::string::npos) << refused.err;
  const Outcome made = Run("mesh box.off --rho 1.4 --json -o m.node");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_LE(std::stod(Value(made.out, "worst_radius_edge")), 1.4 * (1 + 1e-6));
  EXPECT_EQ(Run("verify m.node --input box.off --rho 1.4").code, 0);
  EXPECT_NE(Run("mesh --help").out.find("from 1.4 with polygons"), std::string::npos);
}

TEST_F(SpaceCommands, ACropIsAlongTheAxesOfTheCut) {
  folder_.Write("box.off", kBoxInBox);
  // Cut in the middle of the box, not of the cropped part.
  for (const std::string axis : {"x", "y", "z"}) {
    ASSERT_EQ(Run("mesh box.off -o all.svg --cut " + axis).code, 0);
    ASSERT_EQ(Run("mesh box.off -o crop.svg --crop 0,0,4,4 --cut " + axis).code, 0);
    EXPECT_EQ(folder_.Read("all.svg"), folder_.Read("crop.svg")) << axis;
    EXPECT_NE(folder_.Read("all.svg").find("cut at " + axis + " = 2"), std::string::npos);
  }
}

TEST_F(SpaceCommands, AScriptOfSpaceIsReplayed) {
  folder_.Write("e.dynmesh",
                "mesh dim=3 box=0,0,0,4,4,4\n"
                "add point 1 1 1 1\nadd point 2 3 1 1\nadd point 3 3 3 1\nadd point 4 1 3 1\n"
                "add polygon 5 1 2 3 4\ncommit\n"
                "add size 6 disc 2 2 3 0.5 0.4\nadd size 7 box 0 0 0 1 1 1 0.5\ncommit\n"
                "remove 6\nset point 1 1.1 1 1\ncommit\n");
  const Outcome replayed = Run("replay e.dynmesh --check 1 -o r.node -o r.svg --fill change");
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_NE(replayed.out.find("tetrahedra"), std::string::npos);
  ASSERT_EQ(Run("mesh e.dynmesh -o s.node").code, 0);
  EXPECT_EQ(Run("diff r.node s.node").code, 0);
  EXPECT_EQ(Run("verify r.node --input e.dynmesh").code, 0);
  folder_.Write("bad.dynmesh",
                "mesh dim=3\nadd point 1 0 0 0\nadd point 2 1 0 0\nadd point 3 1 1 0\n"
                "add point 4 0 1 0.5\nadd polygon 5 1 2 3 4\n");
  const Outcome bad = Run("replay bad.dynmesh");
  EXPECT_EQ(bad.code, 2);
  EXPECT_NE(bad.err.find("bad.dynmesh:6: polygon 5 is not flat"), std::string::npos) << bad.err;
}

// Six squares, and a wall where four of them meet.
TEST_F(SpaceCommands, AWallOnAMergedFloorIsMeshed) {
  std::string floor = "OFF\n14 7 0\n";
  for (const char* y : {"0", "2", "4"}) {
    for (const char* x : {"0", "2", "4", "6"}) floor += std::string(x) + " " + y + " 0\n";
  }
  floor +=
      "2 2 2\n4 2 2\n"
      "4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 4 5 9 8\n4 5 6 10 9\n4 6 7 11 10\n4 5 6 13 12\n";
  folder_.Write("floor.off", floor);
  for (const std::string merged : {" --keep-facets", " --keep-facets --merge-coplanar", ""}) {
    SCOPED_TRACE(merged);
    const Outcome made = Run("mesh floor.off -o m.node" + merged);
    ASSERT_EQ(made.code, 0) << made.err;
    EXPECT_EQ(Run("verify m.node --input floor.off" + merged).code, 0);
    // The floor is fewer than six polygons, but more than one.
    const std::string faces = folder_.Read("m.face");
    int floors = 0;
    for (int id = 15; id <= 20; ++id) {
      floors += faces.find(" " + std::to_string(id) + "\n") == std::string::npos ? 0 : 1;
    }
    EXPECT_EQ(floors == 6, merged == " --keep-facets");
    EXPECT_GE(floors, 2);
  }
}

// A slanted square in two triangles: off its plane by the last digit, or by more.
TEST_F(SpaceCommands, FacesInOnePlaneWithinTheDigitsAreOne) {
  const auto write = [&](const std::string& z) {
    folder_.Write("m.off", "OFF\n5 4 0\n0 0 1.1\n2 0 1.1\n2 3 1.2\n0 3 " + z +
                               "\n1 1 3.12345\n3 0 1 2\n3 0 2 3\n3 0 1 4\n3 2 3 4\n");
  };
  write("1.20001");
  const std::string said =
      "dynmesh: warning: m.off: 2 faces joined into 1 polygon(s), 4 corner(s) moved by up to ";
  const Outcome joined = Run("mesh m.off -o m.node");
  EXPECT_EQ(joined.code, 0);
  EXPECT_TRUE(joined.err.starts_with(said)) << joined.err;
  EXPECT_EQ(Run("mesh m.off --surroundings --keep-facets -o k.node").err, "");
  // What judges a mesh reads in the same way.
  const Outcome judged = Run("verify m.node --input m.off");
  EXPECT_EQ(judged.code, 0) << judged.out << judged.err;
  EXPECT_EQ(Run("verify k.node --input m.off --keep-facets").code, 0);
  EXPECT_NE(Run("verify k.node --input m.off").code, 0);
  const std::string summary = Run("import m.off --json -o m.dynmesh").out;
  EXPECT_EQ(Value(summary, "polygons"), "3");
  EXPECT_EQ(Value(summary, "faces_joined"), "2");
  EXPECT_EQ(Value(summary, "polygons_of_joined"), "1");
  EXPECT_EQ(Value(summary, "corners_moved"), "4");
  EXPECT_EQ(Value(Run("import m.off --keep-facets --json -o k.dynmesh").out, "polygons"), "4");
  write("1.201");
  EXPECT_EQ(Run("mesh m.off --surroundings").err, "");
  for (const std::string command : {"mesh", "verify", "import", "load"}) {
    EXPECT_NE(Run(command + " --help").out.find("--keep-facets"), std::string::npos);
    EXPECT_EQ(Run(command + " --help").out.find("--join-flat"), std::string::npos);
  }
}

TEST_F(SpaceCommands, CoplanarFacesAreMergedOnDemand) {
  folder_.Write("m.off", "OFF\n4 2 0\n0 0 1\n2 0 1\n2 3 1\n0 3 1.001\n3 0 1 2\n3 0 2 3\n");
  const auto count = [&](std::optional<double> tolerance) {
    InputFlags flags;
    flags.keep_facets = true;
    flags.merge_coplanar = tolerance.has_value();
    flags.coplanar_tolerance = tolerance.value_or(0);
    const absl::StatusOr<Input> input = LoadInput(folder_.Path("m.off"), flags);
    EXPECT_TRUE(input.ok()) << input.status();
    return std::count_if(input->features.begin(), input->features.end(),
                         [](const Feature& f) { return f.kind == FeatureKind::kPolygon; });
  };
  EXPECT_EQ(count(std::nullopt), 2);
  EXPECT_EQ(count(0), 2);
  EXPECT_EQ(count(0.01), 2);  // no mesh would accept it
  const Outcome warned = Run("mesh m.off --keep-facets --merge-coplanar --coplanar-tolerance 0.01");
  EXPECT_NE(warned.err.find("m.off: 1 part(s) within the tolerance"), std::string::npos)
      << warned.err;
  EXPECT_NE(warned.err.find("flat to 1e-9 of their extent"), std::string::npos);
  folder_.Write("m.off", "OFF\n4 2 0\n0 0 1\n2 0 1\n2 3 1\n0 3 1.000000001\n3 0 1 2\n3 0 2 3\n");
  EXPECT_EQ(count(0), 2);
  EXPECT_EQ(count(0.01), 1);
  EXPECT_EQ(Run("mesh m.off --surroundings --keep-facets --merge-coplanar "
                "--coplanar-tolerance 0.01")
                .err,
            "");
  EXPECT_EQ(Run("mesh m.off --surroundings --keep-facets").err, "");
  EXPECT_NE(Run("verify --help").out.find("--merge-coplanar"), std::string::npos);
  EXPECT_NE(Run("mesh --help").out.find("--merge-coplanar"), std::string::npos);
}

TEST_F(SpaceCommands, FacesOfAScriptAreMerged) {
  folder_.Write("s.dynmesh",
                "mesh dim=3 box=0,0,0,4,4,4\n"
                "add point 1 1 1 1\nadd point 2 3 1 1\nadd point 3 3 3 1\nadd point 4 1 3 1\n"
                "add polygon 6 1 2 3\nadd polygon 5 1 3 4\n");
  EXPECT_EQ(Run("mesh s.dynmesh").code, 0);
  ASSERT_EQ(Run("mesh s.dynmesh --merge-coplanar -o m.node").code, 0);
  EXPECT_EQ(Run("verify m.node --input s.dynmesh --merge-coplanar").code, 0);
  InputFlags flags;
  flags.merge_coplanar = true;
  const auto merged = LoadInput(folder_.Path("s.dynmesh"), flags);
  ASSERT_TRUE(merged.ok());
  EXPECT_EQ(merged->features.size(), 5U);
  EXPECT_TRUE(merged->where(5).ends_with("s.dynmesh:7"));
}

TEST_F(SpaceCommands, InThePlaneThereAreNoFacesToMerge) {
  folder_.Write("s.dynmesh", "mesh dim=2\nadd point 1 0.5 0.5\n");
  folder_.Write("p.node", "1 2 0 0\n1 0 0\n");
  folder_.Write("p.poly", "1 2 0 0\n1 0 0\n0 0\n0\n");
  folder_.Write("p.geojson", R"({"type": "Point", "coordinates": [1, 2]})");
  for (const std::string input : {"s.dynmesh", "p.node", "p.poly", "p.geojson"}) {
    const Outcome refused = Run("mesh " + input + " --merge-coplanar");
    EXPECT_EQ(refused.code, 2) << input;
    EXPECT_NE(refused.err.find(input + " is 2D"), std::string::npos) << refused.err;
  }
  EXPECT_EQ(Run("mesh s.dynmesh --coplanar-tolerance 1").code, 2);  // of what?
}

TEST_F(SpaceCommands, RegionsThatAreNotThereAreTold) {
  folder_.Write("box.off", kBoxInBox);  // polygons 17 to 22 and 23 to 28
  const std::string wanted =
      "lies in polygon 24; the mesh has polygon(s) 17, 23; a closed surface goes by one of its "
      "polygons, mostly the least id";
  EXPECT_EQ(Run("mesh box.off --json --region 23").err, "");
  Outcome none = Run("mesh box.off --json --region 24 -o none.node");
  EXPECT_EQ(none.code, 2);
  EXPECT_EQ(none.out, "");
  EXPECT_NE(none.err.find("--region: nothing of the mesh " + wanted), std::string::npos)
      << none.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("none.node")));
  none = Run("mesh box.off --json --outside 24,23");
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("--outside: nothing of the mesh " + wanted), std::string::npos);
  folder_.Write("r.dynmesh", "mesh dim=3\nadd point 1 0.5 0.5 0.5\n");
  none = Run("replay r.dynmesh --region 5 -o r.node");
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("--region: nothing of the mesh lies in polygon 5; the mesh has no"),
            std::string::npos)
      << none.err;
  for (const std::string command : {"mesh --help", "replay --help"}) {
    EXPECT_NE(Run(command).out.find("the id that `dynmesh stats`"), std::string::npos);
  }
}

TEST_F(SpaceCommands, ExtensionsAreThoseOfAnyCase) {
  folder_.Write("PART.OFF", kBoxInBox);
  const Outcome made = Run("mesh PART.OFF -o M.NODE -o M.VTU -o M.Svg");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(Run("verify M.node --input PART.OFF").code, 0);
  EXPECT_NE(folder_.Read("M.VTU").find("VTKFile"), std::string::npos);
  EXPECT_NE(folder_.Read("M.Svg").find("<svg"), std::string::npos);
  EXPECT_EQ(Run("stats M.NODE").code, 0);
  for (const std::string name : {"a.3mf", "a.STEP", "a.vtk"}) {
    folder_.Write(name, "ply\n");
    const Outcome refused = Run("mesh " + name);
    EXPECT_NE(refused.code, 0);
    EXPECT_NE(refused.err.find(name + ": "), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find(".smesh, .off, .stl, .obj or .ply"), std::string::npos)
        << refused.err;
  }
}

TEST_F(SpaceCommands, MarkersOfInputAreToldOf) {
  // A vertex, a facet of two; with a marker 0 each.
  folder_.Write("m.poly",
                "4 3 0 1\n1 0 0 0 7\n2 4 0 0 0\n3 4 4 0 -1\n4 0 4 0 0\n"
                "2 1\n1 0 5\n4 1 2 3 4\n1 0 0\n2 1 2\n0\n0\n");
  Outcome outcome = Run("mesh m.poly");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string told = " marker(s) of the input: files other than .vtu have ids";
  EXPECT_NE(outcome.err.find("m.poly: 3" + told), std::string::npos) << outcome.err;
  folder_.Write("m.smesh", "0 3\n1 1\n4 1 2 3 4 9\n0\n0\n");
  folder_.Write("m.node", "4 3 0 0\n1 0 0 0\n2 4 0 0\n3 4 4 0\n4 0 4 0\n");
  outcome = Run("mesh m.smesh");
  EXPECT_NE(outcome.err.find("m.smesh: 1" + told), std::string::npos) << outcome.err;
  EXPECT_EQ(Run("mesh m.node").err, "");
  folder_.Write("p.poly", "2 2 0 1\n1 0 0 1\n2 1 0 0\n1 1\n1 1 2 3\n0\n");
  outcome = Run("mesh p.poly");
  EXPECT_NE(outcome.err.find("p.poly: 2" + told), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace dynmesh::cli
