// Triangulations through the service: the library's after every edit, located.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/e2e_fixture.h"
#include "tests/support/same_diff.h"

namespace dynmesh::triangulation_test {
namespace {

class TriangulationEndToEnd : public EndToEndTest {};

TEST_F(TriangulationEndToEnd, IsTheLibrarysAfterEveryEdit) {
  MeshOptions options;
  options.kind = MeshKind::kTriangulation;
  const auto made = client_->CreateMesh("t", options);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->options.kind, MeshKind::kTriangulation);
  const auto mirror = *DynamicMesh::Create(options);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  int applied = 0;
  for (FeatureId round = 0; round < 60; ++round) {
    EditBatch batch;
    const FeatureId first = 10 * round + 1;
    batch.push_back(Edit::Add(Feature::Point(first, unit(random), unit(random))));
    batch.push_back(Edit::Add(Feature::Point(first + 1, unit(random), unit(random))));
    // Refused where it crosses another one.
    batch.push_back(Edit::Add(Feature::Segment(first + 2, first, first + 1)));
    const auto ours = mirror->Apply(batch);
    auto theirs = client_->Apply("t", batch);
    ASSERT_EQ(ours.ok(), theirs.ok()) << theirs.status();
    if (!ours.ok()) continue;
    ++applied;
    EXPECT_EQ(theirs->diff.hash, ours->hash);
    test::ExpectSameRows(theirs->diff, *ours);
  }
  EXPECT_GT(applied, 5);
  Mesh snapshot = *client_->GetSnapshot("t"), whole = mirror->Snapshot();
  Canonicalize(snapshot);
  Canonicalize(whole);
  EXPECT_EQ(snapshot.simplices, whole.simplices);
  EXPECT_EQ(snapshot.hash, whole.hash);
  std::vector<double> points(40);
  for (double& x : points) x = 1.2 * unit(random) - 0.1;
  const auto located = client_->Locate("t", 2, points);
  ASSERT_TRUE(located.ok()) << located.status();
  EXPECT_EQ(located->simplices, mirror->Locate(points));

  const auto size = client_->Apply("t", {Edit::Add(Feature::SizeAt(9999, 0.5, 0.5, 0.1))});
  ASSERT_FALSE(size.ok());
  EXPECT_EQ(codec::GetServiceError(size.status())->reason, reason::kBadSize);
}

}  // namespace
}  // namespace dynmesh::triangulation_test
