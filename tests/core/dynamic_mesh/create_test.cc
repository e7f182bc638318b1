// Meshes of the bare box; max_edge may make them large.
#include <gtest/gtest.h>

#include <atomic>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh::create_test {
namespace {

MeshOptions OptionsIn(int dimension, double max_edge) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.max_edge = max_edge;
  return options;
}

class Create : public ::testing::TestWithParam<int> {};

TEST_P(Create, WithFewerVerticesThanThereMayBeIsAMesh) {
  MeshOptions options = OptionsIn(GetParam(), 0.1);
  const auto mesh = DynamicMesh::Create(options);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_GT((*mesh)->Stats().vertices, 100u);
  EXPECT_EQ((*mesh)->Audit().problems, std::vector<std::string>());
  options.limits.max_vertices = (*mesh)->Stats().vertices;
  EXPECT_EQ((*DynamicMesh::Create(options))->hash(), (*mesh)->hash());
}

TEST_P(Create, WithMoreIsRefusedBeforeTheyAreMade) {
  // By area and by volume a million times too many.
  MeshOptions options = OptionsIn(GetParam(), GetParam() == 2 ? 1e-5 : 1e-3);
  options.limits.max_vertices = 5'000;
  const absl::Status status = DynamicMesh::Create(options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(GetErrorDetail(status)->reason, reason::kVertexLimit);
  EXPECT_NE(std::string(status.message()).find("max_edge"), std::string::npos) << status;
}

TEST_P(Create, EndsWhenInterrupted) {
  const MeshOptions options = OptionsIn(GetParam(), GetParam() == 2 ? 3e-4 : 0.005);
  ApplyOptions apply;
  apply.interrupted = [] { return true; };
  const absl::Status status = DynamicMesh::Create(options, apply).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << status;
}

INSTANTIATE_TEST_SUITE_P(InBothDimensions, Create, ::testing::Values(2, 3));

}  // namespace
}  // namespace dynmesh::create_test
