// Meshes that exceed the range of an index: the edit is refused and undone, as from scratch, and
// later edits are not affected. Uses much smaller indices than the real ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "tests/differential/differential.h"

namespace dynmesh::test::size_limits_test {
namespace {

std::string ReasonOf(const absl::Status& status) {
  const auto detail = GetErrorDetail(status);
  return detail ? detail->reason : status.ToString();
}

// Applies batches, each of which is refused with SIZE_LIMIT if and only if the features after it
// are, from scratch. Returns how many were.
template <int D>
int RunBatches(const std::vector<EditBatch>& batches, const LiveMeshTuning& tuning) {
  LiveMeshTuning from_scratch = tuning;
  from_scratch.rebuild.at_least = 0;
  from_scratch.rebuild.features = -1;
  LiveMesh<D> mesh(DefaultsIn<D>(), tuning);
  Replica replica(mesh);
  int refused = 0;
  for (const EditBatch& batch : batches) {
    const MeshHash before = mesh.hash();
    const auto diff = mesh.Apply(batch, ApplyOptions{});
    LiveMesh<D> fresh(DefaultsIn<D>(), from_scratch);
    if (diff.ok()) {
      const Difference followed = replica.Follow(*diff, mesh);
      EXPECT_FALSE(followed.found) << followed.what;
      EXPECT_TRUE(fresh.Apply(AddAll(mesh.Features()), ApplyOptions{}).ok());
    } else {
      ++refused;
      EXPECT_EQ(diff.status().code(), absl::StatusCode::kResourceExhausted);
      EXPECT_EQ(ReasonOf(diff.status()), reason::kSizeLimit) << diff.status();
      EXPECT_EQ(mesh.hash(), before);
      EXPECT_TRUE(fresh.Apply(AddAll(mesh.Features()), ApplyOptions{}).ok());
      const auto again = fresh.Apply(batch, ApplyOptions{});
      EXPECT_EQ(again.status(), diff.status());
    }
    const Difference d = CompareWithScratch(mesh, refused % 2 == 0);
    EXPECT_FALSE(d.found) << d.what;
  }
  return refused;
}

// Spokes from..to of a hundred around point 1, all neighbours of it.
EditBatch Spokes(FeatureId from, FeatureId to) {
  EditBatch batch;
  for (FeatureId i = from; i < to; ++i) {
    const double angle = 0.06283185307179586 * static_cast<double>(i);
    batch.push_back(Edit::Add(
        Feature::Point(100 + i, 0.5 + 0.3 * std::cos(angle), 0.5 + 0.3 * std::sin(angle))));
    batch.push_back(Edit::Add(Feature::Segment(300 + i, 1, 100 + i)));
  }
  return batch;
}
EditBatch Unmade(const EditBatch& batch) {
  EditBatch inverse;
  for (const Edit& edit : batch) inverse.push_back(Edit::Remove(edit.feature.id));
  std::reverse(inverse.begin(), inverse.end());
  return inverse;
}

TEST(SizeLimits, OfTheNeighboursOfAVertex) {
  for (const std::size_t at_least : {std::size_t{0}, ~std::size_t{0}}) {
    LiveMeshTuning tuning;
    tuning.rebuild.at_least = at_least;
    tuning.engine_limits.reads = 70;
    const EditBatch elsewhere = {Edit::Add(Feature::Point(900, 0.1, 0.9)),
                                 Edit::Add(Feature::Point(901, 0.12, 0.9))};
    const EditBatch centre = {Edit::Add(Feature::Point(1, 0.5, 0.5))};
    EXPECT_EQ(RunBatches<2>({elsewhere, centre, Spokes(0, 100), Spokes(0, 30), Spokes(30, 100),
                             Unmade(elsewhere), Spokes(30, 40), Unmade(Spokes(0, 40)), elsewhere},
                            tuning),
              2);
  }
}

TEST(SizeLimits, OfTheRequestsOfAnOperation) {
  LiveMeshTuning tuning = AlwaysPropagate();
  tuning.engine_limits.requests = 4;
  // Segments at one point, and a point beside it: the new vertices lie in many balls.
  EditBatch segments = {Edit::Add(Feature::Point(1, 0.5, 0.5))};
  for (FeatureId i = 0; i < 36; ++i) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / 36;
    segments.push_back(
        Edit::Add(Feature::Point(10 + i, 0.5 + 0.4 * std::cos(turn), 0.5 + 0.4 * std::sin(turn))));
    segments.push_back(Edit::Add(Feature::Segment(100 + i, 1, 10 + i)));
  }
  tuning.engine_limits.requests = 1u << 20;
  EXPECT_EQ(RunBatches<2>({segments}, tuning), 0);
  tuning.engine_limits.requests = 4;
  EXPECT_EQ(RunBatches<2>({segments, {Edit::Add(Feature::Point(2, 0.51, 0.501))}}, tuning), 1);
}

TEST(SizeLimits, OfTetrahedra) {
  for (const std::size_t at_least : {std::size_t{0}, ~std::size_t{0}}) {
    LiveMeshTuning tuning;
    tuning.rebuild.at_least = at_least;
    tuning.most_tetrahedra = 6'000;
    std::vector<EditBatch> batches;
    for (int k = 0; k < 6; ++k) {
      EditBatch batch;
      for (const Feature& f : MakeFeatures(Distribution::kSpaceUniform, 60, 7 + k)) {
        Feature moved = f;
        moved.id += static_cast<FeatureId>(1000 * k);
        batch.push_back(Edit::Add(moved));
      }
      batches.push_back(batch);
    }
    batches.push_back(Unmade(batches[0]));
    batches.push_back({Edit::Add(Feature::Point(9000, 0.51, 0.52, 0.53))});
    const int refused = RunBatches<3>(batches, tuning);
    EXPECT_GT(refused, 0);
    EXPECT_LT(refused, 6);
  }
}

// Too many points for any mesh within the limit are refused without a start.
TEST(SizeLimits, MorePointsThanVerticesAreRefusedAtOnce) {
  MeshOptions options = DefaultsIn<2>();
  options.limits.max_vertices = 100;
  LiveMesh<2> mesh(options);
  const auto diff =
      mesh.Apply(AddAll(MakeFeatures(Distribution::kUniform, 200, 3)), ApplyOptions{});
  EXPECT_EQ(ReasonOf(diff.status()), reason::kVertexLimit);
  EXPECT_EQ(ReasonOf(BuildMesh(MakeFeatures(Distribution::kUniform, 200, 3), options).status()),
            reason::kVertexLimit);
}

}  // namespace
}  // namespace dynmesh::test::size_limits_test
