// Meshes that do not fill a box: parts, and those of other meshers.
#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "client/verify/containment.h"
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
  // The edges of these simplices, with their owners.
  std::set<std::pair<std::uint32_t, std::uint32_t>> sides;
  io::ForEachSimplex(part.mesh, [&](const auto& simplex) {
    for (const std::uint32_t v : simplex) {
      for (const std::uint32_t w : simplex) {
        if (v < w) sides.emplace(v, w);
      }
    }
  });
  for (io::IndexedMesh::Edge edge : whole.edges) {
    std::tie(edge.a, edge.b) = std::minmax(number[edge.a], number[edge.b]);
    if (sides.contains({edge.a, edge.b})) part.mesh.edges.push_back(edge);
  }
  return part;
}

// Of the checks, that of the input.
VerifyCheck InputCheckOf(const io::MeshFiles& part, const std::vector<Feature>& features) {
  const VerifyReport report =
      VerifyMesh(part, kAnyQuality, &features, std::nullopt, MeshScope::kPart);
  return *std::ranges::find(report.checks, std::string("input"), &VerifyCheck::name);
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

// The middle of a simplex, as an input point of a new id.
template <class Simplex>
Feature MiddleOf(const io::IndexedMesh& mesh, const Simplex& simplex) {
  std::array<double, 3> middle = {0, 0, 0};
  for (const std::uint32_t v : simplex) {
    for (std::size_t k = 0; k < 3; ++k) middle[k] += mesh.vertices[v].position()[k];
  }
  for (double& c : middle) c /= static_cast<double>(simplex.size());
  return Feature::Point(99'999, middle[0], middle[1], middle[2]);
}

// True if one simplex of the mesh alone contains the place. The middle of a nearly flat
// tetrahedron is rounded to its border at times, which belongs to others, too.
bool IsInOneOnly(const io::IndexedMesh& mesh, const std::array<double, 3>& place) {
  int in = 0;
  io::ForEachSimplex(mesh, [&](const auto& simplex) { in += Contains(mesh, simplex, place); });
  return in == 1;
}

TEST(VerifyPart, AnInputPointInThePartThatIsNoVertexIsMissed) {
  const std::uint64_t seed = NewSeed();
  std::mt19937_64 random(seed);
  int in = 0, beside = 0;
  for (std::uint64_t i = 0; i < 8; ++i) {
    SCOPED_TRACE(std::to_string(seed) + " " + std::to_string(i));
    io::IndexedMesh whole;
    std::vector<Feature> features;
    if (i % 2 == 1) {
      const GoodFiles good = MakeGoodFiles(seed + i, 30);
      whole = good.files.mesh, features = good.features;
    } else {
      const auto good = testing::MakePolygonMesh(seed + i, 60);
      whole = good.files.mesh, features = good.features;
    }
    const io::MeshFiles part = SomeOf(whole, random, 50);
    features.emplace_back();
    io::ForEachSimplex(part.mesh, [&](const auto& simplex) {
      if (random() % 8 != 0) return;
      features.back() = MiddleOf(part.mesh, simplex);
      if (!Contains(part.mesh, simplex, features.back().position)) return;
      const VerifyCheck check = InputCheckOf(part, features);
      ASSERT_EQ(check.failures, 1U);
      EXPECT_EQ(check.examples[0], "point 99999 of the input is in the part, and no vertex");
      ++in;
    });
    // In the whole mesh, but not in the part.
    std::set<std::array<double, 3>> middles;
    io::ForEachSimplex(part.mesh, [&](const auto& simplex) {
      middles.insert(MiddleOf(part.mesh, simplex).position);
    });
    io::ForEachSimplex(whole, [&](const auto& simplex) {
      if (random() % 8 != 0) return;
      features.back() = MiddleOf(whole, simplex);
      const std::array<double, 3>& place = features.back().position;
      if (middles.contains(place) || !IsInOneOnly(whole, place)) return;
      EXPECT_EQ(InputCheckOf(part, features).failures, 0U);
      ++beside;
    });
  }
  EXPECT_GT(in, 40);
  EXPECT_GT(beside, 40);
}

// Wherever the part ends: its edges of the input are good, and one without its marker is missed.
TEST(VerifyPart, OfTheInputTheEdgesInThePartAreChecked) {
  const std::uint64_t seed = NewSeed();
  std::mt19937_64 random(seed);
  int missed[2] = {0, 0};
  for (std::uint64_t i = 0; i < 16; ++i) {
    SCOPED_TRACE(std::to_string(seed) + " " + std::to_string(i));
    const bool in_space = i % 2 == 1;
    const unsigned percent = i % 4 < 2 ? 100 : 40 + static_cast<unsigned>(random() % 60);
    io::MeshFiles part;
    std::vector<Feature> features;
    if (in_space) {
      const GoodFiles good = MakeGoodFiles(seed + i, 30);
      part = SomeOf(good.files.mesh, random, percent);
      features = good.features;
    } else {
      const auto good = testing::MakePolygonMesh(seed + i, 60);
      part = SomeOf(good.files.mesh, random, percent);
      features = good.features;
    }
    const VerifyCheck good = InputCheckOf(part, features);
    EXPECT_EQ(good.failures, 0U) << good.examples.front();
    for (io::IndexedMesh::Edge& edge : part.mesh.edges) {
      if (edge.owner == kNoFeature || edge.owner == kBoxFeature) continue;
      const FeatureId owner = std::exchange(edge.owner, kNoFeature);
      const bool is_found = InputCheckOf(part, features).failures != 0;
      // A whole edge of the input whose ends are not in the part is not looked for.
      EXPECT_TRUE(is_found || percent < 100) << edge.a + 1 << "-" << edge.b + 1;
      missed[in_space] += is_found ? 1 : 0;
      edge.owner = owner;
    }
    // On an edge that is on no line of the input, or on that of another feature.
    for (io::IndexedMesh::Edge& edge : part.mesh.edges) {
      if (edge.owner == kBoxFeature) continue;
      const FeatureId owner = std::exchange(edge.owner, FeatureId{77'777});
      EXPECT_NE(InputCheckOf(part, features).failures, 0U);
      edge.owner = owner;
      if (random() % 8 == 0) break;
    }
  }
  EXPECT_GT(missed[0], 40);
  EXPECT_GT(missed[1], 10);
}

// A segment beside the part, that touches it, is none of its edges.
TEST(VerifyPart, SegmentsOutsideOfThePartAreNotMissed) {
  io::MeshFiles part = Triangles({{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{0, 1, 2}, {0, 2, 3}});
  std::vector<Feature> features;
  for (std::uint32_t v = 0; v < 4; ++v) {
    auto& vertex = part.mesh.vertices[v];
    vertex.containing_dimension = 0;
    vertex.owner = v + 1;
    features.push_back(Feature::Point(v + 1, vertex.x, vertex.y));
  }
  part.mesh.edges = {{0, 1, 11}, {0, 2, kNoFeature}, {0, 3, 14}, {1, 2, 12}, {2, 3, 13}};
  for (FeatureId i = 1; i <= 4; ++i) features.push_back(Feature::Segment(10 + i, i, i % 4 + 1));
  features.push_back(Feature::Point(5, -3, -1));
  features.push_back(Feature::Segment(20, 1, 5));
  EXPECT_EQ(InputCheckOf(part, features).failures, 0U);
  // Into a triangle, and along an edge.
  std::vector<Feature> into = features;
  into[8].position = {3, 1, 0};
  EXPECT_EQ(InputCheckOf(part, into).failures, 2U);  // its end is no vertex of the mesh, too
  into[8].position = {2, 2, 0};
  EXPECT_EQ(InputCheckOf(part, into).failures, 1U);  // its end only
  into[8].position = {5, 5, 0};
  EXPECT_EQ(InputCheckOf(part, into).failures, 1U);
}

}  // namespace
}  // namespace dynmesh::cli
