// Quadtrees through the service: the library's after every edit, located, exported.
#include "dynmesh/quadtree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/e2e_fixture.h"
#include "tests/support/same_diff.h"

namespace dynmesh::quadtree_test {
namespace {

class QuadtreeEndToEnd : public EndToEndTest {};

TEST_F(QuadtreeEndToEnd, IsTheLibrarysAfterEveryEdit) {
  for (const int dimension : {2, 3}) {
    MeshOptions options;
    options.dimension = dimension;
    options.quality = DefaultQuality(dimension);
    options.kind = MeshKind::kQuadtree;
    const std::string id = dimension == 2 ? "quadtree" : "octree";
    const auto made = client_->CreateMesh(id, options);
    ASSERT_TRUE(made.ok()) << made.status();
    EXPECT_EQ(made->options.kind, MeshKind::kQuadtree);
    EXPECT_EQ(client_->GetMesh(id)->options.kind, MeshKind::kQuadtree);
    const auto mirror = *DynamicMesh::Create(options);
    client::EditParams params;
    params.dimension = dimension;
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int round = 0; round < 30; ++round) {
      EditBatch batch;
      const FeatureId first = 10 * static_cast<FeatureId>(round) + 1;
      batch.push_back(Edit::Add(Feature::Point(first, unit(random), unit(random), unit(random))));
      batch.push_back(
          Edit::Add(Feature::Point(first + 1, unit(random), unit(random), unit(random))));
      if (dimension == 3) batch.push_back(Edit::Add(Feature::Segment(first + 2, first, first + 1)));
      if (round > 3 && dimension == 2) batch.push_back(Edit::Remove(first - 30));
      const auto ours = mirror->Apply(batch);
      const auto theirs = client_->Apply(id, batch, params);
      ASSERT_EQ(ours.ok(), theirs.ok()) << theirs.status();
      if (!ours.ok()) continue;
      EXPECT_EQ(theirs->diff.hash, ours->hash);
      EXPECT_EQ(theirs->diff.added_vertices, ours->added_vertices);
      EXPECT_EQ(theirs->diff.removed_vertices, ours->removed_vertices);
    }
    Mesh snapshot = *client_->GetSnapshot(id), whole = mirror->Snapshot();
    Canonicalize(snapshot);
    Canonicalize(whole);
    EXPECT_EQ(snapshot.vertices, whole.vertices);
    EXPECT_EQ(snapshot.hash, whole.hash);

    std::vector<double> points(static_cast<std::size_t>(20 * dimension));
    for (double& x : points) x = 1.2 * unit(random) - 0.1;
    const auto located = client_->Locate(id, dimension, points);
    ASSERT_TRUE(located.ok()) << located.status();
    EXPECT_EQ(located->simplices, mirror->Locate(points));
    EXPECT_EQ(located->leaf_sides, mirror->LeafSides(points));
    EXPECT_EQ(located->leaf_sides.size(), 20u);
  }
}

TEST_F(QuadtreeEndToEnd, BadOptionsAndSizingFeaturesAreNamed) {
  MeshOptions options;
  options.kind = MeshKind::kQuadtree;
  options.max_edge = 0.1;
  const auto refused = client_->CreateMesh("q", options);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(codec::GetServiceError(refused.status())->field, "options.max_edge");
  options.max_edge = 0;
  ASSERT_TRUE(client_->CreateMesh("q", options).ok());
  const auto size = client_->Apply("q", {Edit::Add(Feature::SizeAt(3, 0.5, 0.5, 0.1))});
  ASSERT_FALSE(size.ok());
  EXPECT_EQ(codec::GetServiceError(size.status())->reason, reason::kBadSize);
  // A Delaunay mesh has no leaves.
  const std::vector<double> point = {0.5, 0.5};
  EXPECT_TRUE(client_->Locate("m", 2, point)->leaf_sides.empty());
}

}  // namespace
}  // namespace dynmesh::quadtree_test
