#include "core/io/solvers/named_facets.h"

#include <algorithm>
#include <map>
#include <set>

#include "gtest/gtest.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/support/seed.h"

namespace dynmesh::io::named_facets_test {
namespace {

using Corners = std::set<std::uint32_t>;

IndexedMesh Indexed(const Mesh& mesh) {
  auto indexed = IndexMesh(mesh);
  EXPECT_TRUE(indexed.ok());
  return *std::move(indexed);
}

std::vector<std::vector<std::uint32_t>> SimplicesOfAny(const IndexedMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> simplices;
  ForEachSimplex(mesh, [&](const auto& c) { simplices.emplace_back(c.begin(), c.end()); });
  return simplices;
}

// By looking at all facets of all simplices: which simplices have it.
std::map<Corners, std::vector<std::uint32_t>> SidesOf(const IndexedMesh& mesh) {
  std::map<Corners, std::vector<std::uint32_t>> sides;
  const auto simplices = SimplicesOfAny(mesh);
  for (std::uint32_t i = 0; i < simplices.size(); ++i) {
    for (const std::uint32_t without : simplices[i]) {
      Corners corners(simplices[i].begin(), simplices[i].end());
      corners.erase(without);
      sides[corners].push_back(i);
    }
  }
  return sides;
}

void Check(const IndexedMesh& mesh) {
  const auto parts = NamePartsOf(mesh);
  ASSERT_TRUE(parts.ok());
  std::map<Corners, FeatureId> owners;
  for (const auto& e : mesh.edges) {
    if (mesh.dimension == 2 && e.owner != kNoFeature) owners[{e.a, e.b}] = e.owner;
  }
  for (const auto& f : mesh.faces) {
    if (f.owner != kNoFeature) owners[Corners(f.corners.begin(), f.corners.end())] = f.owner;
  }
  const auto sides = SidesOf(mesh);
  std::set<std::string> names;
  std::set<Corners> found;
  for (const FacetSet& set : parts->facets) {
    EXPECT_TRUE(names.insert(set.name).second) << set.name;
    EXPECT_FALSE(set.facets.empty()) << set.name;
    for (const NamedFacet& facet : set.facets) {
      const auto c = CornersOf(mesh, facet);
      const Corners corners(c.begin(), c.begin() + mesh.dimension);
      EXPECT_TRUE(found.insert(corners).second) << "twice";
      const auto& of = sides.at(corners);
      EXPECT_EQ(facet.is_border, of.size() == 1);
      const auto first = *std::ranges::min_element(
          of, {}, [&](std::uint32_t i) { return std::pair(mesh.regions.Of(i), i); });
      EXPECT_EQ(facet.simplex, first);
      const auto owner = owners.find(corners);
      if (owner == owners.end()) {
        EXPECT_TRUE(facet.is_border);
        EXPECT_EQ(set.name, "border");
      } else {
        EXPECT_EQ(set.name, owner->second == kBoxFeature
                                ? "box"
                                : "feature " + std::to_string(owner->second));
      }
    }
  }
  for (const auto& [corners, of] : sides) {
    EXPECT_EQ(found.contains(corners), of.size() == 1 || owners.contains(corners));
  }
  std::vector<int> times(mesh.simplex_count(), 0);
  for (const RegionSet& set : parts->regions) {
    EXPECT_TRUE(names.insert(set.name).second) << set.name;
    EXPECT_TRUE(std::ranges::is_sorted(set.simplices));
    for (const std::uint32_t i : set.simplices) ++times[i];
  }
  EXPECT_EQ(std::ranges::count(times, 1), static_cast<std::ptrdiff_t>(times.size()));
}

TEST(NamedFacets, OfAPlane) {
  Check(Indexed(testing::SampleMesh()));
  Check(Indexed(testing::SampleMeshWithRegions()));
}

TEST(NamedFacets, OfASpace) {
  const std::uint64_t seed = test::NewSeed();
  Check(Indexed(testing::MakeGoodSpaceMesh(seed, 60).mesh));
}

// A part without its box: what lies on no feature is the border.
TEST(NamedFacets, WhatLiesOnNothingIsTheBorder) {
  IndexedMesh mesh = Indexed(testing::SampleMesh());
  mesh.triangles.erase(mesh.triangles.begin() + 2);
  Check(mesh);
}

TEST(NamedFacets, FacetsAreDirected) {
  const IndexedMesh plane = Indexed(testing::SampleMesh());
  for (std::uint32_t i = 0; i < plane.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto c = CornersOf(plane, {i, k, false});
      const auto& a = plane.vertices[c[0]];
      const auto& b = plane.vertices[c[1]];
      const auto& o = plane.vertices[plane.triangles[i][static_cast<std::size_t>(k)]];
      EXPECT_GT((b.x - a.x) * (o.y - a.y) - (b.y - a.y) * (o.x - a.x), 0);
    }
  }
}

TEST(NamedFacets, Words) {
  EXPECT_EQ(WordOf("inlet", 80), "inlet");
  EXPECT_EQ(WordOf("feature 30", 80), "feature_30");
  EXPECT_EQ(WordOf("3 ways", 80), "N3_ways");
  EXPECT_EQ(WordOf("", 80), "N");
  EXPECT_EQ(WordOf("abcdef", 3), "abc");
  EXPECT_EQ(WordsOf({"a b", "a_b", "a-b", "c"}, 80),
            (std::vector<std::string>{"a_b", "a_b_2", "a_b_3", "c"}));
  EXPECT_EQ(WordsOf({"Wall", "wall", "WALL_2", "wall"}, 80),
            (std::vector<std::string>{"Wall", "wall_2", "WALL_2_2", "wall_3"}));
  EXPECT_EQ(WordsOf({"abcdef", "abcdeg"}, 5), (std::vector<std::string>{"abcde", "abc_2"}));
}

}  // namespace
}  // namespace dynmesh::io::named_facets_test
