// Markers, names and attributes of the input in what is written.
#include "client/cli/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "client/cli/input.h"
#include "dynmesh/dynamic_mesh.h"
#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"
#include "tests/support/number_rows.h"

namespace dynmesh::cli::labels_test {
namespace {

// A unit square with a hole, markers everywhere but on segment 3; the attribute is x + y. The
// region has the attribute 7.5 and triangles of at most 0.01.
constexpr char kPlate[] =
    "8 2 1 1\n1 0 0 0 5\n2 1 0 1 5\n3 1 1 2 6\n4 0 1 1 6\n"
    "5 .4 .4 .8 7\n6 .6 .4 1 7\n7 .6 .6 1.2 7\n8 .4 .6 1 -7\n"
    "8 1\n1 1 2 11\n2 2 3 12\n3 3 4 0\n4 4 1 14\n5 5 6 20\n6 6 7 20\n7 7 8 20\n8 8 5 20\n"
    "1\n1 .5 .5\n1\n1 .1 .1 7.5 .01\n";

// Rows of numbers, without comments and the header.
std::vector<std::vector<double>> Rows(const std::string& text) {
  std::vector<std::vector<double>> rows = test::NumberRows(text);
  rows.erase(rows.begin());
  return rows;
}

// The marker that a position of the plate has.
double MarkerAt(double x, double y) {
  const std::map<std::pair<double, double>, double> points = {
      {{0, 0}, 5},   {{1, 0}, 5},   {{1, 1}, 6},   {{0, 1}, 6},
      {{.4, .4}, 7}, {{.6, .4}, 7}, {{.6, .6}, 7}, {{.4, .6}, -7}};
  if (const auto it = points.find({x, y}); it != points.end()) return it->second;
  if (y == 0) return 11;
  if (x == 1) return 12;
  if (y == 1) return 1;  // without a marker, on the border
  if (x == 0) return 14;
  const bool on_hole =
      ((x == .4 || x == .6) && y >= .4 && y <= .6) || ((y == .4 || y == .6) && x >= .4 && x <= .6);
  return on_hole ? 20 : 0;
}

class Labels : public CommandLineFixture {};

TEST_F(Labels, MarkersOfTheInputAreKeptAndInherited) {
  folder_.Write("p.poly", kPlate);
  const Outcome made = Run("mesh p.poly --inside --markers input -o m.node -o m.mesh -o m.msh");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.err, "");
  const auto nodes = Rows(folder_.Read("m.node"));
  ASSERT_GT(nodes.size(), 100U);
  std::set<double> seen;
  for (const auto& row : nodes) {
    ASSERT_EQ(row.size(), 5U);
    EXPECT_EQ(row[4], MarkerAt(row[1], row[2])) << row[1] << " " << row[2];
    EXPECT_NEAR(row[3], row[1] + row[2], 1e-12);  // the attribute
    seen.insert(row[4]);
  }
  EXPECT_EQ(seen, (std::set<double>{-7, 0, 1, 5, 6, 7, 11, 12, 14, 20}));
  std::map<double, int> edges;
  for (const auto& row : Rows(folder_.Read("m.edge"))) {
    const auto &a = nodes[static_cast<std::size_t>(row[1]) - 1],
               &b = nodes[static_cast<std::size_t>(row[2]) - 1];
    EXPECT_EQ(row[3], MarkerAt((a[1] + b[1]) / 2, (a[2] + b[2]) / 2));
    ++edges[row[3]];
  }
  EXPECT_EQ(edges.size(), 6U);  // 0 1 11 12 14 20
  for (const auto& row : Rows(folder_.Read("m.ele"))) {
    ASSERT_EQ(row.size(), 5U);
    EXPECT_EQ(row[4], 7.5);
    double area = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto &p = nodes[static_cast<std::size_t>(row[1 + k]) - 1],
                 &q = nodes[static_cast<std::size_t>(row[1 + (k + 1) % 3]) - 1];
      area += (p[1] * q[2] - q[1] * p[2]) / 2;
    }
    EXPECT_LE(area, 0.01);
  }
  const std::string msh = folder_.Read("m.msh");
  for (const char* group : {"0 5 \"marker 5\"", "1 20 \"marker 20\"", "1 14 \"marker 14\""}) {
    EXPECT_NE(msh.find(group), std::string::npos) << group;
  }
  EXPECT_EQ(msh.find("marker 0"), std::string::npos);
  // As Gmsh saves it: of segment 11, which has no marker, there is a curve, but no element.
  std::istringstream blocks(msh.substr(msh.find("$Elements\n")));
  std::set<std::string> saved;
  for (std::string line; std::getline(blocks, line);) {
    std::istringstream words(line);
    std::string dimension, tag, type, count, more;
    if (words >> dimension >> tag >> type >> count && !(words >> more) && dimension == "1") {
      saved.insert(tag);
    }
  }
  EXPECT_TRUE(saved.contains("9") && saved.contains("12") && !saved.contains("11"));
  // An edge of Medit's file with reference 20.
  const std::string mesh = folder_.Read("m.mesh");
  EXPECT_NE(mesh.substr(mesh.find("Edges"), mesh.find("Triangles")).find(" 20\n"),
            std::string::npos);
  // Such files can be judged, though not by ids.
  EXPECT_EQ(Run("stats m.node").code, 0);
}

// As in Triangle. Sides 1 and 2 must not meet in corners of side 1 alone.
TEST_F(Labels, EndsWithoutAMarkerHaveThatOfTheirFirstSegment) {
  folder_.Write("p.poly",
                "6 2 0 1\n1 0 0 0\n2 1 0 0\n3 1 1 9\n4 0 1 0\n5 .3 .5 0\n6 .5 .5 0\n"
                "5 1\n1 1 2 0\n2 2 3 2\n3 3 4 2\n4 4 1 3\n5 5 6 8\n0\n");
  ASSERT_EQ(Run("mesh p.poly --inside --markers input -o m.node").code, 0);
  std::map<std::pair<double, double>, double> found;
  for (const auto& row : Rows(folder_.Read("m.node"))) found[{row[1], row[2]}] = row[3];
  EXPECT_EQ((found[{0, 0}]), 3);  // the first segment there has none
  EXPECT_EQ((found[{1, 0}]), 2);
  EXPECT_EQ((found[{1, 1}]), 9);
  EXPECT_EQ((found[{0, 1}]), 2);
  EXPECT_EQ((found[{.3, .5}]), 8);
  // A corner of a cube: of the polygon with the least id.
  folder_.Write("c.smesh",
                "8 3 0 0\n1 0 0 0\n2 4 0 0\n3 4 4 0\n4 0 4 0\n5 0 0 4\n6 4 0 4\n7 4 4 4\n"
                "8 0 4 4\n6 1\n4 1 2 3 4 0\n4 5 6 7 8 2\n4 1 2 6 5 3\n4 2 3 7 6 4\n"
                "4 3 4 8 7 5\n4 4 1 5 8 6\n0\n0\n");
  ASSERT_EQ(Run("mesh c.smesh --inside --markers input -o c1.node").code, 0);
  std::map<std::array<double, 3>, double> corners;
  for (const auto& row : Rows(folder_.Read("c1.node"))) {
    corners[{row[1], row[2], row[3]}] = row[4];
  }
  EXPECT_EQ((corners[{0, 0, 0}]), 3);
  EXPECT_EQ((corners[{4, 4, 0}]), 4);
  EXPECT_EQ((corners[{0, 4, 0}]), 5);
  EXPECT_EQ((corners[{4, 4, 4}]), 2);
}

TEST_F(Labels, IdsStayTheDefaultOnSteinerPointsByRequest) {
  folder_.Write("p.poly", kPlate);
  const Outcome made = Run("mesh p.poly -o m.node");
  ASSERT_EQ(made.code, 0);
  ASSERT_EQ(Run("mesh p.poly --markers owners -o o.node").code, 0);
  EXPECT_NE(made.err.find("p.poly: 15 marker(s) of the input"), std::string::npos) << made.err;
  EXPECT_EQ(Run("verify m.node --input p.poly").code, 0);
  for (const std::string name : {"m", "o"}) {
    std::set<double> markers;
    for (const auto& row : Rows(folder_.Read(name + ".node"))) {
      if (row[2] == 0 && row[1] > 0 && row[1] < 1) {  // on segment 9
        EXPECT_EQ(row[4], name == "o" ? 9 : 0);
      }
      markers.insert(row[4]);
    }
    EXPECT_TRUE(markers.contains(8) && markers.contains(-1) && markers.contains(0)) << name;
  }
  // Both say the same of what lies where.
  EXPECT_EQ(Run("verify o.node --input p.poly").code, 0);
  EXPECT_EQ(Run("diff m.node o.node").code, 0);
  EXPECT_EQ(Run("mesh p.poly --markers some -o m.node").code, 2);
}

TEST_F(Labels, OfFacetsAreKeptInSpace) {
  // A cube; every facet has the marker of its number, points none.
  folder_.Write("c.smesh",
                "8 3 1 0\n1 0 0 0 1\n2 4 0 0 5\n3 4 4 0 9\n4 0 4 0 5\n5 0 0 4 0\n6 4 0 4 4\n"
                "7 4 4 4 8\n8 0 4 4 4\n6 1\n4 1 2 3 4 1\n4 5 6 7 8 2\n4 1 2 6 5 3\n4 2 3 7 6 4\n"
                "4 3 4 8 7 5\n4 4 1 5 8 6\n0\n1\n1 2 2 2 3 .5\n");
  const Outcome made = Run("mesh c.smesh --inside --markers input -o m.node -o m.vtu");
  ASSERT_EQ(made.code, 0) << made.err;
  const auto nodes = Rows(folder_.Read("m.node"));
  for (const auto& row : nodes) {
    ASSERT_EQ(row.size(), 6U);
    EXPECT_NEAR(row[4], row[1] + row[2] - row[3] / 4 + 1, 1e-9);
    const bool inside =
        row[1] > 0 && row[1] < 4 && row[2] > 0 && row[2] < 4 && row[3] > 0 && row[3] < 4;
    EXPECT_EQ(row[5] == 0, inside);
  }
  for (const auto& row : Rows(folder_.Read("m.face"))) {
    std::array<double, 3> sum{};
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        sum[i] += nodes[static_cast<std::size_t>(row[1 + k]) - 1][1 + i];
      }
    }
    const double wanted = sum[2] == 0    ? 1
                          : sum[2] == 12 ? 2
                          : sum[1] == 0  ? 3
                          : sum[0] == 12 ? 4
                          : sum[1] == 12 ? 5
                                         : 6;
    EXPECT_EQ(row[4], wanted);
  }
  const auto tetrahedra = Rows(folder_.Read("m.ele"));
  for (const auto& row : tetrahedra) EXPECT_EQ(row.back(), 3);
}

TEST_F(Labels, FacesOfDifferentMarkersAreNotJoined) {
  // A square of two triangles with one marker, beside two with another.
  folder_.Write("f.smesh",
                "6 3 0 0\n1 0 0 0\n2 4 0 0\n3 8 0 0\n4 0 4 0\n5 4 4 0\n6 8 4 0\n"
                "4 1\n3 1 2 5 7\n3 1 5 4 7\n3 2 3 6 8\n3 2 6 5 8\n0\n0\n");
  InputFlags flags;
  flags.merge_coplanar = true;
  const auto input = LoadInput(folder_.Path("f.smesh"), flags);
  ASSERT_TRUE(input.ok()) << input.status();
  std::map<std::int64_t, std::size_t> corners;
  for (const Feature& f : input->features) {
    EXPECT_NE(f.kind, FeatureKind::kSegment);
    if (f.kind == FeatureKind::kPolygon) corners[input->labels->MarkerOf(f.id)] = f.rings[0].size();
  }
  EXPECT_EQ(corners, (std::map<std::int64_t, std::size_t>{{7, 4}, {8, 4}}));
}

TEST_F(Labels, NamesGoFromScriptsAndMapsIntoFiles) {
  folder_.Write("s.dynmesh",
                "mesh box=0,0,4,4\nadd point 1 0 0\nadd point 2 4 0\nadd point 3 4 4\n"
                "add point 4 0 4\nadd segment 5 1 2\nadd segment 6 2 3\nadd polygon 9 1 2 3 4\n"
                "name 5 Inlet of \"gas\"\nname 6 Wall\nname 9 Plate\nmarker 5 42\nmarker 6 0\n");
  Outcome made = Run("mesh s.dynmesh --inside -o m.node -o m.msh -o m.vtu -o m.mesh");
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string msh = folder_.Read("m.msh");
  EXPECT_NE(msh.find("1 5 \"Inlet of 'gas'\"\n"), std::string::npos) << msh.substr(0, 600);
  EXPECT_NE(msh.find("2 2 \"Plate\"\n"), std::string::npos);
  EXPECT_NE(folder_.Read("m.mesh").find("# reference 6: feature 6, Wall\n"), std::string::npos);
  const std::string vtu = folder_.Read("m.vtu");
  for (const char* name : {"Inlet of &quot;gas&quot;", "Wall", "Plate"}) {
    EXPECT_NE(vtu.find(std::string("Name=\"") + name + "\" NumberOfTuples=\"1\""),
              std::string::npos)
        << name;
  }
  EXPECT_NE(folder_.Read("m.node").find("# dynmesh name 5 Inlet of \"gas\"\n"), std::string::npos);
  const Outcome stats = Run("stats m.node --json");
  EXPECT_NE(stats.out.find("\"names\": {\"5\": \"Inlet of \\\"gas\\\"\""), std::string::npos)
      << stats.out;
  ASSERT_EQ(Run("replay s.dynmesh --markers input -o r.node").code, 0);
  std::set<double> markers;
  for (const auto& row : Rows(folder_.Read("r.edge"))) markers.insert(row[3]);
  EXPECT_EQ(markers, (std::set<double>{0, 1, 42}));
  folder_.Write("m.geojson",
                R"({"type": "Feature", "properties": {"name": "Mohave"}, "geometry":
                {"type": "Polygon", "coordinates": [[[0,0],[4,0],[4,4],[0,4],[0,0]]]}})");
  made = Run("mesh m.geojson --polygons --inside -o g.msh");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(folder_.Read("g.msh").find("\"Mohave\"\n"), std::string::npos);
}

// "dimension number" of the physical groups, by name. A reader that looks them up by name must find
// each: no name is there twice.
std::map<std::string, std::string> GroupsOf(const std::string& msh) {
  std::map<std::string, std::string> groups;
  std::istringstream lines(msh.substr(msh.find("$PhysicalNames\n")));
  std::string line;
  std::getline(lines, line), std::getline(lines, line);
  while (std::getline(lines, line) && line[0] != '$') {
    const std::size_t quote = line.find('"');
    const std::string name = line.substr(quote + 1, line.size() - quote - 2);
    EXPECT_TRUE(groups.emplace(name, line.substr(0, quote - 1)).second)
        << name << " is there twice";
  }
  return groups;
}

// The third column of a section of Medit's: references of triangles or tetrahedra.
std::map<long, int> ReferencesOf(const std::string& mesh, const std::string& section) {
  std::istringstream words(mesh.substr(mesh.find("\n" + section + "\n") + section.size() + 2));
  std::size_t count = 0;
  words >> count;
  std::map<long, int> references;
  for (std::size_t i = 0; i < count; ++i) {
    long value = 0;
    for (int k = 0; k < (section == "Triangles" ? 4 : 5); ++k) words >> value;
    ++references[value];
  }
  return references;
}

// A plate with an inclusion.
constexpr char kPlateWithInclusion[] =
    "mesh box=0,0,12,8\n"
    "add point 1 0 0\nadd point 2 12 0\nadd point 3 12 8\nadd point 4 0 8\n"
    "add point 5 4 2\nadd point 6 8 2\nadd point 7 8 6\nadd point 8 4 6\n"
    "add polygon 100 1 2 3 4\nadd polygon 200 5 6 7 8\nadd segment 11 4 1\n"
    "name 100 wall\nname 200 inclusion\nname 11 inflow\n"
    "marker 100 3\nmarker 200 4\nmarker 11 1\n";

TEST_F(Labels, TrianglesHaveTheNameAndTheMarkerOfTheirPolygonAndItsBorderAnotherName) {
  folder_.Write("s.dynmesh", kPlateWithInclusion);
  for (const std::string part : {"", "--region 100 "}) {
    ASSERT_EQ(Run("mesh s.dynmesh " + part + "-o i.msh").code, 0);
    auto ids = GroupsOf(folder_.Read("i.msh"));
    EXPECT_EQ(ids.at("wall"), "2 2");
    EXPECT_EQ(ids.at("inclusion"), "2 3");
    EXPECT_EQ(ids.at("wall edges")[0], '1');
    EXPECT_EQ(ids.at("inclusion edges")[0], '1');
    EXPECT_EQ(ids.at("inflow")[0], '1');
    const Outcome made =
        Run("mesh s.dynmesh " + part + "--markers input -o m.msh -o m.mesh -o m.vtu -o m.node");
    ASSERT_EQ(made.code, 0) << made.err;
    const auto groups = GroupsOf(folder_.Read("m.msh"));
    EXPECT_EQ(groups.at("wall"), "2 3");
    EXPECT_EQ(groups.at("inclusion"), "2 4");
    EXPECT_EQ(groups.at("wall edges"), "1 3");
    EXPECT_EQ(groups.at("inclusion edges"), "1 4");
    EXPECT_EQ(groups.at("inflow"), "1 1");
    EXPECT_EQ(groups.count("domain"), part.empty() ? 1U : 0U);
    const std::string mesh = folder_.Read("m.mesh");
    const auto references = ReferencesOf(mesh, "Triangles");
    EXPECT_GT(references.at(3), 0);
    EXPECT_GT(references.at(4), 0);
    EXPECT_EQ(references.size(), part.empty() ? 3U : 2U);
    EXPECT_NE(mesh.find("# triangle reference 3: polygon 100, wall\n"), std::string::npos);
    EXPECT_NE(mesh.find("# triangle reference 4: polygons 100 200, inclusion\n"),
              std::string::npos);
    std::map<double, int> attributes;
    for (const auto& row : Rows(folder_.Read("m.ele"))) ++attributes[row.back()];
    EXPECT_EQ(attributes[3], references.at(3));
    EXPECT_EQ(attributes[4], references.at(4));
  }
  // In a part, too, the inclusion is the inclusion's.
  ASSERT_EQ(Run("mesh s.dynmesh --region 200 --markers input -o p.msh").code, 0);
  EXPECT_EQ(GroupsOf(folder_.Read("p.msh")).at("inclusion"), "2 4");
}

TEST_F(Labels, AnOverlapIsNoPolygonsOwnAndRegionsOfOneNameAreOneGroup) {
  folder_.Write("o.dynmesh",
                "mesh box=0,0,9,9\nadd point 1 0 0\nadd point 2 6 0\nadd point 3 6 6\n"
                "add point 4 0 6\nadd point 5 3 3\nadd point 6 9 3\nadd point 7 9 9\n"
                "add point 8 3 9\nadd point 9 6 3\nadd point 10 3 6\n"
                "add polygon 20 1 2 9 3 10 4\nadd polygon 30 5 9 6 7 8 10\n"
                "name 20 metal\nname 30 metal\nmarker 20 5\nmarker 30 5\n");
  ASSERT_EQ(Run("mesh o.dynmesh -o o.msh").code, 0);
  auto groups = GroupsOf(folder_.Read("o.msh"));
  EXPECT_EQ(groups.at("metal"), "2 2");
  EXPECT_EQ(groups.at("polygons 20 30"), "2 3");
  ASSERT_EQ(Run("mesh o.dynmesh --markers input -o m.msh").code, 0);
  groups = GroupsOf(folder_.Read("m.msh"));
  EXPECT_EQ(groups.at("metal"), "2 5");
  EXPECT_EQ(groups.at("polygons 20 30"), "2 2");  // a number that no marker has
  // Two names of one marker, and one name of two markers.
  folder_.Write("n.dynmesh", folder_.Read("o.dynmesh") + "marker 30 6\nmarker 7 6\nname 7 metal\n");
  ASSERT_EQ(Run("mesh n.dynmesh --markers input -o n.msh").code, 0);
  groups = GroupsOf(folder_.Read("n.msh"));
  EXPECT_EQ(groups.at("metal"), "2 5");
  EXPECT_EQ(groups.at("metal 6"), "2 6");
}

// A cube in a room: polygons 901 to 906 and 5001 to 5006.
std::string CubeInARoom() {
  std::string script = "mesh dim=3 box=0,0,0,12,12,12\n";
  const auto add = [&](int point, int polygon, double lo, double hi) {
    const char* const faces[] = {"1 2 3 4", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"};
    for (int k = 0; k < 8; ++k) {
      const double x = k % 4 == 1 || k % 4 == 2 ? hi : lo, y = k % 4 >= 2 ? hi : lo;
      script += "add point " + std::to_string(point + k + 1) + " " + std::to_string(x) + " " +
                std::to_string(y) + " " + std::to_string(k >= 4 ? hi : lo) + "\n";
    }
    for (int f = 0; f < 6; ++f) {
      script += "add polygon " + std::to_string(polygon + f);
      std::istringstream corners(faces[f]);
      for (int corner = 0; corners >> corner;) script += " " + std::to_string(point + corner);
      script += "\n";
    }
  };
  add(0, 901, 0, 12);
  add(10, 5001, 4, 8);
  const char* const names[] = {"bottom", "top", "front", "right", "back", "left"};
  for (int f = 0; f < 6; ++f) {
    script += "name " + std::to_string(901 + f) + " " + names[f] + "\nmarker " +
              std::to_string(901 + f) + " " + std::to_string(f + 1) + "\nname " +
              std::to_string(5001 + f) + " cube\nmarker " + std::to_string(5001 + f) + " 10\n";
  }
  return script;
}

TEST_F(Labels, AVolumeHasTheNameOfItsSurfaceOnlyIfAllPolygonsOfThatHaveIt) {
  folder_.Write("s.dynmesh", CubeInARoom());
  for (const std::string part : {"--region 901 ", "--inside ", ""}) {
    Outcome made = Run("mesh s.dynmesh " + part + "-o i.msh");
    ASSERT_EQ(made.code, 0) << made.err;
    auto groups = GroupsOf(folder_.Read("i.msh"));
    EXPECT_EQ(groups.at("polygon 901"), "3 2");
    EXPECT_EQ(groups.at("cube"), "3 3");
    EXPECT_EQ(groups.at("cube faces")[0], '2');
    EXPECT_EQ(groups.at("cube edges")[0], '1');
    EXPECT_EQ(groups.at("bottom")[0], '2');
    EXPECT_EQ(groups.at("bottom edges")[0], '1');
    made = Run("mesh s.dynmesh " + part + "--markers input -o m.msh -o m.mesh -o m.node");
    ASSERT_EQ(made.code, 0) << made.err;
    groups = GroupsOf(folder_.Read("m.msh"));
    EXPECT_EQ(groups.at("polygon 901"), "3 1");
    EXPECT_EQ(groups.at("cube"), "3 10");
    EXPECT_EQ(groups.at("cube faces"), "2 10");
    EXPECT_EQ(groups.at("bottom"), "2 1");
    const std::string mesh = folder_.Read("m.mesh");
    const auto references = ReferencesOf(mesh, "Tetrahedra");
    EXPECT_GT(references.at(10), 0);
    EXPECT_GT(references.at(1), 0);
    EXPECT_NE(mesh.find("# tetrahedron reference 10: polygons 901 5001, cube\n"),
              std::string::npos);
    std::map<double, int> attributes;
    for (const auto& row : Rows(folder_.Read("m.ele"))) ++attributes[row.back()];
    EXPECT_EQ(attributes[10], references.at(10));
  }
  ASSERT_EQ(Run("mesh s.dynmesh --region 5001 -o p.msh").code, 0);
  EXPECT_EQ(GroupsOf(folder_.Read("p.msh")).at("cube")[0], '3');
}

TEST_F(Labels, LargestVolumesOfRegionsAreObeyed) {
  const std::string cube =
      "8 3 0 0\n1 0 0 0\n2 4 0 0\n3 4 4 0\n4 0 4 0\n5 0 0 4\n6 4 0 4\n7 4 4 4\n8 0 4 4\n6 0\n"
      "4 1 2 3 4\n4 5 6 7 8\n4 1 2 6 5\n4 2 3 7 6\n4 3 4 8 7\n4 4 1 5 8\n0\n1\n";
  folder_.Write("c.smesh", cube + "1 2 2 2 3 .25\n");
  const Outcome made = Run("mesh c.smesh --inside -o m.node");
  ASSERT_EQ(made.code, 0) << made.err;
  const auto nodes = Rows(folder_.Read("m.node"));
  const auto tetrahedra = Rows(folder_.Read("m.ele"));
  EXPECT_GT(tetrahedra.size(), 256U);  // 64 / .25
  for (const auto& row : tetrahedra) {
    std::array<std::array<double, 3>, 3> e;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        e[k][i] = nodes[static_cast<std::size_t>(row[2 + k]) - 1][1 + i] -
                  nodes[static_cast<std::size_t>(row[1]) - 1][1 + i];
      }
    }
    const double volume = (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                           e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
                          6;
    EXPECT_LE(volume, .25 * (1 + 1e-12));
  }
  folder_.Write("on.smesh", cube + "1 0 2 2 3 .25\n");
  const Outcome on = Run("mesh on.smesh --inside");
  EXPECT_EQ(on.code, 2);
  EXPECT_NE(on.err.find("on.smesh:19: the place of a region is on a facet"), std::string::npos)
      << on.err;
}

TEST_F(Labels, AreImported) {
  folder_.Write("p.poly", kPlate);
  ASSERT_EQ(Run("import p.poly -o q.poly").code, 0);
  ASSERT_EQ(Run("mesh p.poly --markers input -o p1.node").code, 0);
  ASSERT_EQ(Run("mesh q.poly --markers input -o q1.node").code, 0);
  for (const char* extension : {".node", ".edge", ".ele"}) {
    EXPECT_EQ(folder_.Read(std::string("p1") + extension),
              folder_.Read(std::string("q1") + extension));
  }
  ASSERT_EQ(Run("import p.poly -o q.dynmesh").code, 0);
  EXPECT_NE(folder_.Read("q.dynmesh").find("\nmarker 9 11\n"), std::string::npos);
  EXPECT_NE(Run("import p.poly --clean -o c.poly").err.find("left out by --clean"),
            std::string::npos);
  folder_.Write("m.geojson",
                R"({"type": "Feature", "properties": {"name": "A # B"}, "geometry":
                {"type": "Polygon", "coordinates": [[[0,0],[4,0],[4,4],[0,4],[0,0]]]}})");
  ASSERT_EQ(Run("import m.geojson --polygons -o m.dynmesh").code, 0);
  EXPECT_NE(folder_.Read("m.dynmesh").find("\nname 5 A   B\n"), std::string::npos);
}

TEST_F(Labels, NamesOfGroupsOfAMeshStay) {
  folder_.Write("g.msh",
                "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 7 \"Inlet\"\n"
                "2 1 \"Lower\"\n2 2 \"Upper\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n"
                "3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n3\n1 1 2 7 1 1 2\n2 2 2 1 1 1 2 3\n"
                "3 2 2 2 2 1 3 4\n$EndElements\n");
  for (const std::string flags : {"--inside", "--refine", "--inside --markers input"}) {
    ASSERT_EQ(Run("mesh g.msh " + flags + " -o m.msh").code, 0);
    const std::string msh = folder_.Read("m.msh");
    for (const char* name : {" \"Inlet\"\n", " \"Lower\"\n", " \"Upper\"\n"}) {
      EXPECT_NE(msh.find(name), std::string::npos) << flags << name;
    }
  }
  EXPECT_NE(folder_.Read("m.msh").find("2 1 \"Lower\"\n2 2 \"Upper\"\n"), std::string::npos);
  // Features of one name are one group.
  folder_.Write("s.dynmesh",
                "mesh box=0,0,4,4\nadd point 1 0 0\nadd point 2 4 0\nadd point 3 4 4\n"
                "add segment 4 1 2\nadd segment 5 2 3\nname 4 Wall\nname 5 Wall\n");
  ASSERT_EQ(Run("mesh s.dynmesh -o w.msh").code, 0);
  const std::string walls = folder_.Read("w.msh");
  ASSERT_NE(walls.find("\"Wall\""), std::string::npos);
  EXPECT_EQ(walls.find("\"Wall\""), walls.rfind("\"Wall\""));
}

TEST_F(Labels, ScriptsWithBadLabelsAreRefused) {
  for (const char* line :
       {"marker 1", "marker x 1", "marker 1 x", "marker 1 2 3", "name 1", "name x y", "name 0 y"}) {
    folder_.Write("s.dynmesh", std::string("mesh box=0,0,1,1\n") + line + "\n");
    const Outcome outcome = Run("mesh s.dynmesh");
    EXPECT_EQ(outcome.code, 2) << line;
    EXPECT_NE(outcome.err.find("s.dynmesh:2: "), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace dynmesh::cli::labels_test
