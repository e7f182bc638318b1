// `dynmesh import` of surfaces.
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

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
  EXPECT_EQ(Run("mesh soup.stl --exact").code, 2);
  EXPECT_EQ(Run("mesh soup.stl").code, 0);
  // The reader mends what it can by itself, and says so. Faces still cross.
  const Outcome plain = Run("import soup.stl -o plain.off");
  EXPECT_EQ(plain.code, 0);
  EXPECT_NE(plain.err.find(" face(s) twice left out"), std::string::npos) << plain.err;
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
    // Of surface files faces are joined, unless they are to be kept.
    const Outcome mesh = Run("mesh --keep-facets --json " + out);
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
  // Two sheets that meet at 0.03 degrees.
  folder_.Write("wedge.off", "OFF\n4 2 0\n0 0 0\n0 1 0\n1 0.5 0\n1 0.5 0.0005\n3 0 1 2\n3 0 1 3\n");
  const Outcome outcome = Run("import wedge.off --clean -o out.off");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("refused by a mesh  1 (SMALL_INPUT_ANGLE 1)"), std::string::npos)
      << outcome.out;
  EXPECT_EQ(folder_.Read("out.off"),
            "OFF\n4 2 0\n0 0 0\n0 1 0\n1 0.5 0\n1 0.5 5e-04\n3 0 1 2\n3 0 1 3\n");
}

TEST_F(ImportSurface, OfNearlyFlatPatchesOnlyFeatureEdgesAreKept) {
  // A cube of 8 x 8 squares a side; the lower half of its faces has the marker 5.
  std::string points, faces, markers;
  std::map<std::array<int, 3>, int> ids;
  int polygons = 0;
  const auto id = [&](const std::array<int, 3>& p) {
    const auto [it, is_new] = ids.try_emplace(p, static_cast<int>(ids.size()) + 1);
    if (is_new) {
      points += "add point " + std::to_string(it->second);
      for (const int x : p) points += " " + std::to_string(x);
      points += "\n";
    }
    return std::to_string(it->second);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int at : {0, 8}) {
      for (int i = 0; i < 8; ++i) {
        for (int j = 0; j < 8; ++j) {
          const auto corner = [&](int a, int b) {
            std::array<int, 3> p{};
            p[axis] = at;
            p[(axis + 1) % 3] = a;
            p[(axis + 2) % 3] = b;
            return p;
          };
          const std::string name = std::to_string(1000 + polygons++);
          faces += "add polygon " + name;
          bool is_low = true;
          for (const auto& [a, b] : {std::pair(i, j), std::pair(i + 1, j), std::pair(i + 1, j + 1),
                                     std::pair(i, j + 1)}) {
            faces += " " + id(corner(a, b));
            is_low = is_low && corner(a, b)[2] <= 4;
          }
          faces += "\n";
          if (is_low) markers += "marker " + name + " 5\n";
        }
      }
    }
  }
  folder_.Write("cube.dynmesh",
                "mesh dim=3 box=-1,-1,-1,9,9,9\n" + points + faces + "commit\n" + markers);
  const std::string command = "import cube.dynmesh --clean --feature-angle 30 ";
  const Outcome outcome = Run(command + "--json -o out.smesh");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> lines = Lines(outcome.out);
  const std::string& summary = lines.back();
  EXPECT_EQ(Value(summary, "polygons_read"), "384");
  EXPECT_EQ(Value(summary, "polygons"), "20");  // two triangles for each half of a side
  EXPECT_EQ(Value(summary, "points"), "12");
  EXPECT_EQ(Value(summary, "point_dropped"), "374");
  EXPECT_EQ(Value(summary, "feature_angle"), "30");
  EXPECT_EQ(Value(summary, "sharp_edges"), "20");
  EXPECT_EQ(Value(summary, "corners"), "12");
  EXPECT_EQ(Value(summary, "refused"), "0");
  EXPECT_EQ(Value(summary, "largest_step"), "0");
  EXPECT_NEAR(std::stod(Value(summary, "within")), 0.008 * std::sqrt(3.0), 1e-6);
  EXPECT_NE(lines[0].find("{\"change\": \"point dropped\", \"ids\": ["), std::string::npos);
  // Half of the faces have the marker.
  std::size_t marked = 0;
  for (const std::string& line : Lines(folder_.Read("out.smesh"))) {
    marked += line.starts_with("3 ") && line.ends_with(" 5") ? 1 : 0;
  }
  EXPECT_EQ(marked, 10U);
  const Outcome text = Run(command + "--within 0.5 -o out.off");
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_NE(text.out.find("point dropped      374\n"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("sharp edges        20, sharper than 30 degrees\n"), std::string::npos);
  EXPECT_NE(text.out.find("surface within     0.5\n"), std::string::npos);
  ASSERT_EQ(Run("mesh out.off -o out.msh").code, 0);
  const Outcome verdict = Run("verify out.msh --input out.off");
  EXPECT_EQ(verdict.code, 0) << verdict.out << verdict.err;
}

TEST_F(ImportSurface, ACurvedSurfaceMadeCoarseMeshesWithFewerVertices) {
  // A torus of 48 x 24 quadrangles, as triangles.
  constexpr int kRound = 48, kTube = 24;
  std::ostringstream off;
  off.precision(17);
  off << "OFF\n" << kRound * kTube << " " << 2 * kRound * kTube << " 0\n";
  for (int i = 0; i < kRound; ++i) {
    for (int j = 0; j < kTube; ++j) {
      const double u = 2 * std::numbers::pi * i / kRound, v = 2 * std::numbers::pi * j / kTube;
      const double r = 2 + std::cos(v);
      off << r * std::cos(u) << " " << r * std::sin(u) << " " << std::sin(v) << "\n";
    }
  }
  for (int i = 0; i < kRound; ++i) {
    for (int j = 0; j < kTube; ++j) {
      const auto at = [&](int a, int b) { return a % kRound * kTube + b % kTube; };
      off << "3 " << at(i, j) << " " << at(i + 1, j) << " " << at(i + 1, j + 1) << "\n"
          << "3 " << at(i, j) << " " << at(i + 1, j + 1) << " " << at(i, j + 1) << "\n";
    }
  }
  folder_.Write("torus.off", off.str());
  ASSERT_EQ(Run("import torus.off --clean --feature-angle 40 --within 0.08 -o coarse.off").code, 0);
  const Outcome fine = Run("mesh --json --keep-facets torus.off");
  const Outcome coarse = Run("mesh --json coarse.off -o coarse.msh");
  ASSERT_EQ(fine.code, 0) << fine.err;
  ASSERT_EQ(coarse.code, 0) << coarse.err;
  EXPECT_LT(2 * std::stol(Value(coarse.out, "vertices")), std::stol(Value(fine.out, "vertices")));
  const Outcome verdict = Run("verify coarse.msh --input coarse.off");
  EXPECT_EQ(verdict.code, 0) << verdict.out << verdict.err;
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
  expect("-o b.off --feature-angle 30", "--feature-angle needs --clean");
  expect("-o b.off --clean --within 1", "--within needs --feature-angle");
  expect("-o b.off --clean --feature-angle 0", "must be from 0.1 to 89 degrees, found 0");
  expect("-o b.off --clean --feature-angle 90", "must be from 0.1 to 89 degrees, found 90");
  expect("-o b.off --clean --feature-angle 30 --within 0", "--within: it must be above 0, found 0");
  expect("-o b.off --clean --feature-angle 30 --within inf", "--within: it must be");
  folder_.Write("flat.poly", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n1 0\n1 1 2\n0\n");
  const Outcome flat = Run("import flat.poly --clean --feature-angle 30 -o b.poly");
  EXPECT_EQ(flat.code, 2);
  EXPECT_NE(flat.err.find("--feature-angle is for surfaces; flat.poly is 2D"), std::string::npos)
      << flat.err;
  expect("-o b.off --box 0,0,0,0.5,1,1", "is outside --box");
}

// Triangles between random places, which cross nearly all others.
std::string Soup(int triangles) {
  std::string points, faces;
  std::uint64_t state = 1;
  const auto next = [&] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return std::to_string(static_cast<double>(state >> 40) / (1 << 24));
  };
  for (int i = 0; i < triangles; ++i) {
    for (int k = 0; k < 3; ++k) points += next() + " " + next() + " " + next() + "\n";
    faces += "3 " + std::to_string(3 * i) + " " + std::to_string(3 * i + 1) + " " +
             std::to_string(3 * i + 2) + "\n";
  }
  return "OFF\n" + std::to_string(3 * triangles) + " " + std::to_string(triangles) + " 0\n" +
         points + faces;
}

TEST_F(ImportSurface, CleaningEndsAfterItsStepsWithAPlace) {
  folder_.Write("s.off", Soup(20));
  const Outcome few = Run("import s.off --clean -o c.poly --max-steps 100");
  EXPECT_EQ(few.code, 1);
  EXPECT_NE(few.err.find("cleaning takes too many steps: in round 1"), std::string::npos)
      << few.err;
  EXPECT_NE(few.err.find("one at ("), std::string::npos) << few.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("c.poly")));
  // In a later round.
  const Outcome later = Run("import s.off --clean -o c.poly --max-steps 1000");
  EXPECT_EQ(later.code, 1);
  EXPECT_NE(later.err.find("in round "), std::string::npos) << later.err;
  EXPECT_EQ(Run("import s.off --clean -o c.poly").code, 0);
  EXPECT_EQ(Run("import s.off --clean -o c.poly --max-steps 0").code, 2);
}

TEST_F(ImportSurface, WhatAMeshStillRefusesIsCountedUpToTen) {
  // Twelve times two sheets that meet at 0.03 degrees.
  std::string points, faces;
  for (int i = 0; i < 12; ++i) {
    const std::string x = std::to_string(2 * i), far = std::to_string(2 * i + 1);
    points += x + " 0 0\n" + x + " 1 0\n" + far + " 0.5 0\n" + far + " 0.5 0.0005\n";
    const auto corner = [i](int k) { return " " + std::to_string(4 * i + k); };
    for (const int third : {2, 3}) faces += "3" + corner(0) + corner(1) + corner(third) + "\n";
  }
  folder_.Write("s.off", "OFF\n48 24 0\n" + points + faces);
  const Outcome ten = Run("import s.off --clean -o c.poly --json");
  ASSERT_EQ(ten.code, 0) << ten.err;
  const std::string all = Lines(Run("import s.off --clean -o c.poly --json --all").out).back();
  const int count = std::stoi(Value(all, "refused"));
  ASSERT_GT(count, 10);
  EXPECT_EQ(Value(all, "refused_all_counted"), "true");
  EXPECT_EQ(Value(Lines(ten.out).back(), "refused"), "10");
  EXPECT_EQ(Value(Lines(ten.out).back(), "refused_all_counted"), "false");
  EXPECT_NE(Run("import s.off --clean -o c.poly").out.find("refused by a mesh  at least 10"),
            std::string::npos);
}

}  // namespace
}  // namespace dynmesh::cli
