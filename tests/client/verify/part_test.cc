// Meshes that do not fill a box: parts, and those of other meshers.
#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "client/verify/verify.h"
#include "gtest/gtest.h"
#include "tests/client/verify/good_files.h"
#include "tests/client/verify/good_mesh.h"
#include "tests/client/verify/report_text.h"

namespace dynmesh::cli {
namespace {

// Some simplices of the mesh, and the vertices that they use.
io::MeshFiles SomeOf(const io::IndexedMesh& whole, std::mt19937_64& random, unsigned percent) {
  io::MeshFiles part;
  part.mesh.dimension = whole.dimension;
  std::vector<std::uint32_t> number(whole.vertices.size(), ~std::uint32_t{0});
  const auto take = [&](const auto& simplices, auto& to) {
    for (auto s : simplices) {
      if (random() % 100 >= percent) continue;
      for (std::uint32_t& v : s) {
        if (number[v] == ~std::uint32_t{0}) {
          number[v] = static_cast<std::uint32_t>(part.mesh.vertices.size());
          part.mesh.vertices.push_back(whole.vertices[v]);
        }
        v = number[v];
      }
      to.push_back(s);
    }
  };
  take(whole.triangles, part.mesh.triangles);
  take(whole.tetrahedra, part.mesh.tetrahedra);
  return part;
}

VerifyReport JudgeForeign(const io::MeshFiles& files) {
  return VerifyMesh(files, 2, nullptr, std::nullopt, MeshScope::kForeign, false);
}

TEST(VerifyPart, AcceptsAnyPartOfAGoodMesh) {
  const std::uint64_t seed = NewSeed();
  std::mt19937_64 random(seed);
  for (std::uint64_t i = 0; i < 10; ++i) {
    const unsigned percent = 20 + static_cast<unsigned>(random() % 80);
    const auto plane = testing::MakeGoodMesh(seed + i, 60);
    const VerifyReport in_plane = JudgeForeign(SomeOf(plane.files.mesh, random, percent));
    EXPECT_TRUE(in_plane.Passed()) << Describe(in_plane);
    EXPECT_EQ(in_plane.not_delaunay, 0U);
    const GoodFiles space = MakeGoodFiles(seed + i, 30);
    const VerifyReport in_space = JudgeForeign(SomeOf(space.files.mesh, random, percent));
    EXPECT_TRUE(in_space.Passed()) << Describe(in_space);
  }
  // The whole is a part, too; then it is judged by all else.
  const auto good = testing::MakeGoodMesh(seed, 60);
  const VerifyReport whole =
      VerifyMesh(good.files, kAnyQuality, &good.features, std::nullopt, MeshScope::kPart);
  EXPECT_TRUE(whole.Passed()) << Describe(whole);
  EXPECT_EQ(whole.checks.size(), 10U);
}

TEST(VerifyPart, FindsAVertexThatWasMoved) {
  const std::uint64_t seed = NewSeed();
  std::mt19937_64 random(seed);
  for (std::uint64_t i = 0; i < 20; ++i) {
    const bool in_space = i % 2 == 1;
    io::MeshFiles part = SomeOf(in_space ? MakeGoodFiles(seed + i, 30).files.mesh
                                         : testing::MakeGoodMesh(seed + i, 60).files.mesh,
                                random, 100);
    // Into a simplex that it is no corner of: something turns over, or overlaps.
    auto& vertices = part.mesh.vertices;
    const auto moved = static_cast<std::uint32_t>(random() % vertices.size());
    const auto move_into = [&](const auto& simplices) {
      std::size_t s = 0;
      do {
        s = random() % simplices.size();
      } while (std::ranges::count(simplices[s], moved) != 0);
      double x = 0, y = 0, z = 0;
      for (const std::uint32_t corner : simplices[s]) {
        x += vertices[corner].x, y += vertices[corner].y, z += vertices[corner].z;
      }
      const auto corners = static_cast<double>(simplices[s].size());
      auto& v = vertices[moved];
      v.x = x / corners, v.y = y / corners, v.z = z / corners;
    };
    if (in_space) {
      move_into(part.mesh.tetrahedra);
    } else {
      move_into(part.mesh.triangles);
    }
    EXPECT_FALSE(JudgeForeign(part).Passed()) << seed << " " << i;
  }
}

io::MeshFiles Triangles(std::vector<std::array<double, 2>> positions,
                        std::vector<io::IndexedMesh::Triangle> triangles) {
  io::MeshFiles files;
  for (const auto& [x, y] : positions) files.mesh.vertices.push_back({x, y, 2, kNoFeature});
  files.mesh.triangles = std::move(triangles);
  return files;
}

TEST(VerifyPart, FindsWhatOverlapsWithoutACommonSide) {
  // A star of two triangles: no vertex lies in the other one.
  const io::MeshFiles star =
      Triangles({{0, 0}, {6, 0}, {3, 6}, {0, 4}, {3, -2}, {6, 4}}, {{0, 1, 2}, {3, 4, 5}});
  EXPECT_EQ(FailedChecks(JudgeForeign(star)), std::set<std::string>{"overlap"});
  // One in the other.
  const io::MeshFiles nested =
      Triangles({{0, 0}, {9, 0}, {0, 9}, {1, 1}, {2, 1}, {1, 2}}, {{0, 1, 2}, {3, 4, 5}});
  EXPECT_EQ(FailedChecks(JudgeForeign(nested)), std::set<std::string>{"overlap"});
  // They touch at a vertex of both, which is no overlap; at one of one of them only, it is.
  EXPECT_TRUE(
      JudgeForeign(Triangles({{0, 0}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}}, {{0, 1, 2}, {0, 3, 4}}))
          .Passed());
  EXPECT_FALSE(JudgeForeign(Triangles({{0, 0}, {2, 0}, {0, 2}, {1, 0}, {0, -1}, {2, -1}},
                                      {{0, 1, 2}, {3, 4, 5}}))
                   .Passed());
  // In space two tetrahedra that pierce each other like fingers.
  io::MeshFiles pierced;
  pierced.mesh.dimension = 3;
  for (const auto& [x, y, z] : std::vector<std::array<double, 3>>{{-1, -1, 0},
                                                                  {1, -1, 0},
                                                                  {0, 1, 0},
                                                                  {0, 0, 9},
                                                                  {-9, 0, 4},
                                                                  {9, -.1, 4},
                                                                  {9, .1, 4},
                                                                  {9, 0, 4.1}}) {
    pierced.mesh.vertices.push_back({x, y, 3, kNoFeature, z});
  }
  pierced.mesh.tetrahedra = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  EXPECT_EQ(FailedChecks(JudgeForeign(pierced)), std::set<std::string>{"overlap"})
      << Describe(JudgeForeign(pierced));
}

TEST(VerifyPart, TellsButForgivesWhatIsNotDelaunay) {
  const io::MeshFiles kite = Triangles({{0, 0}, {4, -1}, {8, 0}, {4, 1}}, {{0, 1, 2}, {0, 2, 3}});
  const VerifyReport told = JudgeForeign(kite);
  EXPECT_TRUE(told.Passed()) << Describe(told);
  EXPECT_EQ(told.not_delaunay, 1U);
  // With a bound the quality is judged.
  EXPECT_EQ(FailedChecks(VerifyMesh(kite, 1, nullptr, std::nullopt, MeshScope::kForeign, true)),
            std::set<std::string>{"quality"});
  EXPECT_TRUE(FailedChecks(VerifyMesh(kite, 1, nullptr, std::nullopt, MeshScope::kPart))
                  .contains("delaunay"));
}

TEST(VerifyPart, OfTheInputThePointsAreChecked) {
  const auto good = testing::MakeGoodMesh(7, 40);
  std::vector<Feature> features = good.features;
  const auto point =
      std::ranges::find(features, FeatureKind::kPoint, [](const Feature& f) { return f.kind; });
  ASSERT_NE(point, features.end());
  point->position[0] += 1e-9;
  const auto failed =
      FailedChecks(VerifyMesh(good.files, kAnyQuality, &features, std::nullopt, MeshScope::kPart));
  EXPECT_TRUE(failed.contains("input"));
}

}  // namespace
}  // namespace dynmesh::cli
