#include "core/io/meshes/indexed_mesh.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "tests/core/io/meshes/sample_mesh.h"

namespace dynmesh::io {
namespace {

using testing::SampleMesh;
using testing::SampleMeshWithRegions;

TEST(IndexMesh, NumbersInputPointsFirstThenBoxSegmentsFree) {
  const auto indexed = IndexMesh(SampleMesh());
  ASSERT_TRUE(indexed.ok()) << indexed.status();
  using Vertex = IndexedMesh::Vertex;
  EXPECT_EQ(indexed->vertices, (std::vector<Vertex>{{2, 3.1, 0, 10},
                                                    {10, 3.1, 0, 20},
                                                    {0, 0, 0, kBoxFeature},
                                                    {0, 6, 0, kBoxFeature},
                                                    {4, 0, 1, kBoxFeature},
                                                    {12, 0, 0, kBoxFeature},
                                                    {12, 6, 0, kBoxFeature},
                                                    {6, 3.1, 1, 30},
                                                    {8, 1.0 / 3, 2, kNoFeature}}));
  EXPECT_EQ(indexed->triangles.size(), 11U);
  EXPECT_TRUE(std::is_sorted(indexed->triangles.begin(), indexed->triangles.end()));
  for (const auto& t : indexed->triangles) EXPECT_LT(t[0], std::min(t[1], t[2]));
  EXPECT_EQ(indexed->edges.size(), 19U);  // V - E + T = 1
  EXPECT_EQ(std::count_if(indexed->edges.begin(), indexed->edges.end(),
                          [](const auto& e) { return e.owner != kNoFeature; }),
            7);
  EXPECT_EQ(indexed->edges[0].a, 0U);
}

TEST(IndexMesh, DoesNotDependOnTheOrderOfRows) {
  Mesh mesh = SampleMesh();
  const auto before = IndexMesh(mesh);
  Canonicalize(mesh);
  const auto after = IndexMesh(mesh);
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_EQ(before->vertices, after->vertices);
  EXPECT_EQ(before->triangles, after->triangles);
  EXPECT_EQ(before->edges, after->edges);
}

TEST(IndexMesh, AndBackIsTheSameMesh) {
  Mesh mesh = SampleMesh();
  Mesh back = ToMesh(IndexMesh(mesh).value());
  Canonicalize(mesh);
  Canonicalize(back);
  EXPECT_EQ(back.vertices, mesh.vertices);
  EXPECT_EQ(back.simplices, mesh.simplices);
  EXPECT_EQ(back.subsegments, mesh.subsegments);
  EXPECT_EQ(back.hash, mesh.hash);
}

TEST(IndexMesh, AndBackHasTheSameRegions) {
  Mesh mesh = SampleMeshWithRegions();
  Mesh back = ToMesh(IndexMesh(mesh).value());
  Canonicalize(mesh);
  EXPECT_EQ(IndexMesh(mesh)->regions, IndexMesh(back)->regions);
  Canonicalize(back);
  EXPECT_EQ(back.simplices, mesh.simplices);
  EXPECT_EQ(back.regions, mesh.regions);
  EXPECT_EQ(back.region_sets, mesh.region_sets);
  EXPECT_EQ(back.hash, mesh.hash);
}

TEST(IndexMesh, RefusesRowsThatNameUnknownVertices) {
  Mesh mesh = SampleMesh();
  mesh.simplices[4] = 5;
  EXPECT_EQ(IndexMesh(mesh).status().code(), absl::StatusCode::kInvalidArgument);
  mesh = SampleMesh();
  mesh.subsegments.ends[4] = 5;
  EXPECT_EQ(IndexMesh(mesh).status().code(), absl::StatusCode::kInvalidArgument);
  mesh = SampleMesh();
  mesh.vertices.ids[1] = mesh.vertices.ids[0];
  EXPECT_EQ(IndexMesh(mesh).status().code(), absl::StatusCode::kInvalidArgument);
  mesh = SampleMesh();
  mesh.vertices.owners.pop_back();
  EXPECT_EQ(IndexMesh(mesh).status().code(), absl::StatusCode::kInvalidArgument);
  mesh = SampleMesh();
  mesh.dimension = 3;
  EXPECT_EQ(IndexMesh(mesh).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(ToMesh, GivesVerticesInOnePlaceIdsOfTheirOwn) {
  IndexedMesh indexed;
  indexed.vertices.assign(100'000, {1, 2, 2, kNoFeature});  // and does so in linear time
  const Mesh mesh = ToMesh(indexed);
  std::vector<VertexId> ids = mesh.vertices.ids;
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::unique(ids.begin(), ids.end()), ids.end());
  const double p[2] = {1, 2};
  EXPECT_EQ(mesh.vertices.ids[0], VertexIdAt(p, 2));
  EXPECT_EQ(mesh.vertices.ids[1], VertexIdAt(p, 2, 1));
  EXPECT_EQ(mesh.vertices.ids[2], VertexIdAt(p, 2, 2));
}

TEST(IndexMesh, OfPlainIdsTheHashIsThatOfTheMesh) {
  Mesh mesh = SampleMeshWithRegions();
  IndexedMesh indexed = IndexMesh(mesh).value();
  EXPECT_TRUE(indexed.has_plain_ids);
  EXPECT_EQ(ToMesh(indexed).hash, mesh.hash);
  // A vertex with another id, as at a crack.
  const VertexId salted = VertexIdAt(mesh.vertices.coordinates.data(), 2, 1);
  for (auto* const column : {&mesh.simplices, &mesh.subsegments.ends}) {
    std::ranges::replace(*column, mesh.vertices.ids[0], salted);
  }
  mesh.vertices.ids[0] = salted;
  EXPECT_FALSE(IndexMesh(mesh)->has_plain_ids);
}

TEST(IndexMesh, OfEqualKeysPositionsDecide) {
  // Points of one feature, and free vertices above each other; the last one of a huge id.
  Mesh mesh;
  const auto add = [&](double x, double y, std::uint8_t dimension, FeatureId owner) {
    const double at[2] = {x, y};
    mesh.vertices.ids.push_back(VertexIdAt(at, 2));
    mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), {x, y});
    mesh.vertices.containing_dimensions.push_back(dimension);
    mesh.vertices.owners.push_back(owner);
  };
  for (const double y : {5, 3, 4}) add(1, y, 2, kNoFeature);
  for (const double y : {2, 1, 0}) add(7, y, 0, 9);
  add(0, 0, 0, kLastFeatureId);
  add(1e300, 0, 2, kNoFeature);
  add(-1e300, 0, 2, kNoFeature);
  for (const double y : {8, 7}) add(2, y, 1, 3);
  const auto indexed = IndexMesh(mesh);
  ASSERT_TRUE(indexed.ok());
  std::vector<std::pair<double, double>> found;
  for (const auto& v : indexed->vertices) found.emplace_back(v.x, v.y);
  EXPECT_EQ(found, (std::vector<std::pair<double, double>>{{7, 0},
                                                           {7, 1},
                                                           {7, 2},
                                                           {0, 0},
                                                           {2, 7},
                                                           {2, 8},
                                                           {-1e300, 0},
                                                           {1, 3},
                                                           {1, 4},
                                                           {1, 5},
                                                           {1e300, 0}}));
}

TEST(IndexMesh, ListsEachEdgeOncePerOwner) {
  Mesh mesh = SampleMesh();
  const auto ends = [&](std::size_t i) {
    return std::array{mesh.subsegments.ends[2 * i], mesh.subsegments.ends[2 * i + 1]};
  };
  const auto add = [&](const std::array<VertexId, 2>& edge, FeatureId owner) {
    mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), edge.begin(), edge.end());
    mesh.subsegments.owners.push_back(owner);
  };
  add(ends(0), 31);  // of two segments
  add(ends(0), 31);
  add(ends(1), kNoFeature);                                       // has an owner already
  add({mesh.vertices.ids[0], mesh.vertices.ids[2]}, 77);          // no edge of a triangle
  add({mesh.vertices.ids[0], mesh.vertices.ids[8]}, kNoFeature);  // the same, of nothing
  const auto indexed = IndexMesh(mesh);
  ASSERT_TRUE(indexed.ok());
  EXPECT_EQ(indexed->edges.size(), 19U + 3);
  std::vector<FeatureId> owners;
  for (const auto& e : indexed->edges) {
    if (e.owner != kNoFeature) owners.push_back(e.owner);
  }
  EXPECT_EQ(std::ranges::count(owners, FeatureId{30}), 2);
  EXPECT_EQ(std::ranges::count(owners, FeatureId{31}), 1);
  EXPECT_EQ(std::ranges::count(owners, FeatureId{77}), 1);
  EXPECT_TRUE(std::ranges::is_sorted(indexed->edges, {}, [](const auto& e) {
    return std::tuple(e.a, e.b, e.owner == kNoFeature, e.owner);
  }));
}

}  // namespace
}  // namespace dynmesh::io
