// Elements as features and seeds.
#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "core/io/elements/element_mesh.h"
#include "gtest/gtest.h"

namespace dynmesh::io {
namespace {

// Squares of a 4 x 4 grid, two triangles each, without the one at (1, 1), with `marker(x, y)`.
template <class MarkerOf>
ElementMesh Ring(MarkerOf marker) {
  ElementMesh mesh;
  mesh.file = "ring.msh";
  for (int y = 0; y <= 4; ++y) {
    for (int x = 0; x <= 4; ++x) {
      mesh.positions.push_back({static_cast<double>(x), static_cast<double>(y), 0});
      mesh.lines.push_back(static_cast<int>(mesh.positions.size()));
    }
  }
  for (std::uint32_t y = 0; y < 4; ++y) {
    for (std::uint32_t x = 0; x < 4; ++x) {
      if (x == 1 && y == 1) continue;
      const std::uint32_t a = 5 * y + x, b = a + 1, c = a + 6, d = a + 5;
      mesh.triangles.push_back({{a, b, c}, marker(x, y), 1});
      mesh.triangles.push_back({{a, c, d}, marker(x, y), 1});
    }
  }
  return mesh;
}

std::size_t Count(const FileFeatures& input, FeatureKind kind) {
  return static_cast<std::size_t>(std::ranges::count(input.features, kind, &Feature::kind));
}

bool IsIn(const SeedRow& seed, double x0, double y0, double x1, double y1) {
  return seed.position[0] > x0 && seed.position[0] < x1 && seed.position[1] > y0 &&
         seed.position[1] < y1;
}

TEST(ElementFeatures, OfAMeshAreItsBorderAndSeedsOfWhatIsBeyond) {
  const ElementMesh mesh = Ring([](auto, auto) { return 0; });
  const FileFeatures input = FeaturesOf(mesh, ElementVertices::kOfConstraints);
  EXPECT_EQ(input.point_count, 20U);  // 16 outside, 4 around the hole
  EXPECT_EQ(input.segment_count, 20U);
  EXPECT_TRUE(input.regions.empty());
  ASSERT_EQ(input.holes.size(), 2U);  // beyond either part of the border
  const auto in_hole =
      std::ranges::count_if(input.holes, [](const SeedRow& s) { return IsIn(s, 1, 1, 2, 2); });
  const auto outside = std::ranges::count_if(
      input.holes, [](const SeedRow& s) { return !IsIn(s, -0.001, -0.001, 4.001, 4.001); });
  EXPECT_EQ(in_hole, 1);
  EXPECT_EQ(outside, 1);
  EXPECT_EQ(FeaturesOf(mesh, ElementVertices::kAll).point_count, 25U);
}

TEST(ElementFeatures, LiesBetweenMarkersWhichAreRegions) {
  ElementMesh mesh = Ring([](auto x, auto) { return x < 2 ? 5 : 9; });
  mesh.segments.push_back({{0, 1}, 7, 3});
  mesh.points.push_back({{24}, 4, 3});
  mesh.names = {{{1, 7}, "Inlet"}, {{0, 4}, "Corner"}};
  const FileFeatures input = FeaturesOf(mesh, ElementVertices::kOfConstraints);
  EXPECT_EQ(input.segment_count, 20U + 3);  // x = 2, but for the side of the hole
  ASSERT_EQ(input.regions.size(), 2U);
  for (const SeedRow& seed : input.regions) {
    ASSERT_EQ(seed.more.size(), 1U);
    EXPECT_TRUE(seed.more[0] == 5 ? IsIn(seed, 0, 0, 2, 4) : IsIn(seed, 2, 0, 4, 4));
    EXPECT_FALSE(IsIn(seed, 1, 1, 2, 2));
  }
  // The given line comes first, with its marker and name.
  const Feature& line = input.features[input.point_count];
  EXPECT_EQ(input.labels.MarkerOf(line.id), 7);
  EXPECT_EQ(input.labels.NameOf(line.id), "Inlet");
  EXPECT_EQ(input.labels.NameOf(input.point_count), "Corner");  // the last vertex of the grid
  EXPECT_EQ(input.labels.markers.size(), 2U);
}

TEST(ElementFeatures, InSpaceTheyAreTheBordersFaces) {
  ElementMesh mesh;
  mesh.file = "t.vtu";
  mesh.dimension = 3;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {9, 9, 9}};
  mesh.lines.assign(6, 1);
  mesh.tetrahedra = {{{0, 1, 2, 3}, 1, 1}, {{1, 2, 3, 4}, 2, 1}};
  mesh.triangles = {{{0, 1, 2}, 8, 1}};
  mesh.segments = {{{0, 1}, 0, 1}, {{0, 2}, 3, 1}};
  mesh.names = {{{2, 8}, "Floor"}};
  const FileFeatures input = FeaturesOf(mesh, ElementVertices::kOfConstraints);
  EXPECT_EQ(input.point_count, 5U);
  EXPECT_EQ(Count(input, FeatureKind::kPolygon), 7U);  // six of the border, one between
  EXPECT_EQ(input.segment_count, 1U);                  // the one with a marker
  EXPECT_EQ(input.regions.size(), 2U);
  EXPECT_EQ(input.holes.size(), 1U);
  std::set<std::string> names;
  for (const auto& [id, name] : input.labels.names) names.insert(name);
  EXPECT_EQ(names, std::set<std::string>{"Floor"});
  EXPECT_EQ(FeaturesOf(mesh, ElementVertices::kAll).point_count, 6U);
  // One of the tetrahedra is turned over; if most are, all are turned.
  IndexedMesh indexed = ToIndexed(mesh);
  EXPECT_EQ(indexed.tetrahedra.size(), 2U);
  EXPECT_EQ(indexed.faces.size(), 6U);
  EXPECT_EQ(indexed.edges.size(), 9U);
}

TEST(ElementFeatures, OfPointsAloneAreThePoints) {
  ElementMesh mesh;
  mesh.file = "p.msh";
  mesh.positions = {{0, 0, 0}, {1, 0, 0}};
  mesh.lines = {1, 2};
  mesh.points = {{{1}, 0, 3}};
  EXPECT_EQ(FeaturesOf(mesh, ElementVertices::kOfConstraints).point_count, 1U);
  EXPECT_EQ(FeaturesOf(ElementMesh(), ElementVertices::kAll).features.size(), 0U);
}

}  // namespace
}  // namespace dynmesh::io
