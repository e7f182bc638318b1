#include "core/io/meshes/indexed_mesh.h"

#include <algorithm>

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

}  // namespace
}  // namespace dynmesh::io
