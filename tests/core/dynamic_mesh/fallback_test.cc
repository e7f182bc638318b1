// A propagation that costs more than a build is replaced by one: mesh, trace and diff are the same,
// and no edit executes many more operations than a build. Also batches with a limit of operations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "tests/differential/differential.h"
#include "tests/support/polygon_script.h"
#include "tests/support/same_diff.h"

namespace dynmesh::test::fallback_test {
namespace {

constexpr std::uint64_t kSeed = 11;

// Gives up after a number of operations, whatever the mesh.
LiveMeshTuning GivesUpAfter(std::uint64_t operations) {
  LiveMeshTuning tuning = AlwaysPropagate();
  tuning.rebuild.at_least_work = operations;
  tuning.rebuild.work = tuning.rebuild.work_of_stale = 0;
  return tuning;
}

template <int D, class Generator>
void ExpectGivingUpToBeUnseen(Generator generator, int revisions) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  LiveMesh<D> propagated(DefaultsIn<D>(), AlwaysPropagate());
  int given_up = 0;
  for (int revision = 0; revision < revisions;) {
    const EditBatch batch = generator.Next(propagated.Features());
    if (batch.empty() || !propagated.Validate(batch).ok()) continue;
    const EditBatch present = AddAll(propagated.Features());
    auto expected = propagated.Apply(batch, ApplyOptions());
    ASSERT_TRUE(expected.ok()) << expected.status();
    Canonicalize(*expected);
    const AuditReport audit = propagated.Audit();
    for (std::uint64_t after = 0; after < expected->work.executed; after = 2 * after + 3) {
      LiveMesh<D> mesh(DefaultsIn<D>(), GivesUpAfter(after));
      ASSERT_TRUE(mesh.Apply(present, ApplyOptions()).ok());
      mesh.ResumeAt(expected->from_revision);
      const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
      ApplyOptions refuse;
      refuse.commit = [](const MeshDiff&) { return absl::UnavailableError("no"); };
      ASSERT_TRUE(absl::IsUnavailable(mesh.Apply(batch, refuse).status()));
      EXPECT_EQ(mesh.hash(), hash);
      EXPECT_EQ(mesh.Audit().trace, trace);
      auto diff = mesh.Apply(batch, ApplyOptions());
      ASSERT_TRUE(diff.ok()) << diff.status();
      Canonicalize(*diff);
      ExpectSameRows(*diff, *expected);
      EXPECT_EQ(mesh.Audit().trace, audit.trace);
      EXPECT_EQ(mesh.Audit().problems, std::vector<std::string>());
      EXPECT_GT(diff->work.executed, after);
      ++given_up;
    }
    ASSERT_FALSE(testing::Test::HasFailure());
    ++revision;
  }
  EXPECT_GE(given_up, 2 * revisions);
}

TEST(Fallback, IsNotSeenInTheDiff) {
  for (const Distribution d : {Distribution::kUniform, Distribution::kWedges, Distribution::kSized,
                               Distribution::kSegmentsTurned, Distribution::kPolygons}) {
    SCOPED_TRACE(NameOf(d));
    ExpectGivingUpToBeUnseen<2>(ScriptGenerator(d, 20, kSeed), 8);
  }
  ExpectGivingUpToBeUnseen<3>(ScriptGenerator(Distribution::kSpaceSized, 10, kSeed), 2);
  ExpectGivingUpToBeUnseen<3>(PolygonScript(kPolygonKinds[0], 2, kSeed), 3);
}

TEST(Fallback, StoppedAnywhereBringsTheFormerTraceBack) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  ScriptGenerator generator(Distribution::kSegmentsTurned, 15, kSeed);
  LiveMesh<2> mesh(DefaultsIn<2>(), GivesUpAfter(20));
  int stopped = 0;
  for (int revision = 0; revision < 4;) {
    const EditBatch batch = generator.Next(mesh.Features());
    if (batch.empty() || !mesh.Validate(batch).ok()) continue;
    const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
    for (int stop = 0;; stop += 1 + stop / 8, ++stopped) {
      int asked = 0;
      const auto diff = mesh.Apply(batch, {.interrupted = [&] { return asked++ == stop; }});
      if (diff.ok()) break;
      ASSERT_TRUE(absl::IsCancelled(diff.status()));
      ASSERT_EQ(mesh.hash(), hash) << "stop " << stop;
      ASSERT_EQ(mesh.Audit().trace, trace) << "stop " << stop;
    }
    ++revision;
    const Difference d = CompareWithScratch(mesh, true);
    ASSERT_FALSE(d.found) << d.what;
  }
  EXPECT_GT(stopped, 40);
}

// --- The worst edits known: few features, all of the mesh. --------------------------------------

// Parallel lines, as far apart as they are many.
std::vector<Feature> Comb(int lines) {
  std::vector<Feature> features;
  FeatureId id = 1;
  for (int i = 0; i < lines; ++i) {
    const double y = 0.1 + 0.8 * i / (lines - 1);
    features.push_back(Feature::Point(id, 0.1, y));
    features.push_back(Feature::Point(id + 1, 0.9, y));
    features.push_back(Feature::Segment(id + 2, id, id + 1));
    id += 3;
  }
  return features;
}

// Two walls, near each other.
std::vector<Feature> Channel(double width) {
  return {Feature::Point(1, 0.1, 0.5),         Feature::Point(2, 0.9, 0.5),
          Feature::Segment(3, 1, 2),           Feature::Point(4, 0.1, 0.5 + width),
          Feature::Point(5, 0.9, 0.5 + width), Feature::Segment(6, 4, 5)};
}

// Two squares above each other.
std::vector<Feature> Slab(double thickness) {
  std::vector<Feature> features;
  for (int k = 0; k < 2; ++k) {
    const FeatureId first = 1 + 5 * k;
    const double z = 0.5 + thickness * k;
    features.push_back(Feature::Point(first, 0.2, 0.2, z));
    features.push_back(Feature::Point(first + 1, 0.8, 0.2, z));
    features.push_back(Feature::Point(first + 2, 0.8, 0.8, z));
    features.push_back(Feature::Point(first + 3, 0.2, 0.8, z));
    features.push_back(Feature::Polygon(first + 4, {{first, first + 1, first + 2, first + 3}}));
  }
  return features;
}

// A point is added and removed. Each time the operations are at most those of one and a half
// builds, plus the minimum before a propagation is given up.
template <int D>
void ExpectAtMostOneAndAHalfBuilds(const std::vector<Feature>& scene, const Feature& point) {
  const RebuildThresholds thresholds;
  LiveMesh<D> mesh(DefaultsIn<D>());
  ASSERT_TRUE(mesh.Apply(AddAll(scene), ApplyOptions()).ok());
  const double before = static_cast<double>(mesh.Stats().operations);
  for (const Edit& edit : {Edit::Add(point), Edit::Remove(point.id)}) {
    const auto diff = mesh.Apply({edit}, ApplyOptions());
    ASSERT_TRUE(diff.ok()) << diff.status();
    const double build = std::max(before, static_cast<double>(mesh.Stats().operations));
    EXPECT_LE(static_cast<double>(diff->work.executed),
              1.5 * build + static_cast<double>(thresholds.at_least_work));
    const Difference d = CompareWithScratch(mesh, true);
    ASSERT_FALSE(d.found) << d.what;
  }
}

TEST(Fallback, BoundsTheWorstEdits) {
  for (const int lines : {20, 60}) {
    SCOPED_TRACE("comb of " + std::to_string(lines));
    const double gap = 0.8 / (lines - 1);
    ExpectAtMostOneAndAHalfBuilds<2>(Comb(lines),
                                     Feature::Point(99'999, 0.437, 0.1 + 0.8 / 2 + 0.37 * gap));
  }
  for (const double width : {0.01, 0.001}) {
    SCOPED_TRACE("channel " + std::to_string(width));
    ExpectAtMostOneAndAHalfBuilds<2>(Channel(width),
                                     Feature::Point(99'999, 0.437, 0.5 + 0.4 * width));
  }
  ExpectAtMostOneAndAHalfBuilds<3>(Slab(0.02), Feature::Point(99'999, 0.43, 0.56, 0.509));
}

// --- How much a batch may execute ----------------------------------------------------------------

template <int D>
void ExpectTheWorkLimitToHold(const std::vector<Feature>& scene, const LiveMeshTuning& tuning) {
  const auto one = [&](LiveMesh<D>& mesh) {
    ASSERT_TRUE(
        mesh.Apply({Edit::Add(Feature::Point(50'000, 0.3, 0.3, 0.3))}, ApplyOptions()).ok());
  };
  LiveMesh<D> free(DefaultsIn<D>(), tuning);
  one(free);
  const auto unlimited = free.Apply(AddAll(scene), ApplyOptions());
  ASSERT_TRUE(unlimited.ok()) << unlimited.status();
  ASSERT_GT(unlimited->work.executed, 100u);
  ApplyOptions apply;
  for (const std::uint64_t most :
       {std::uint64_t{1}, unlimited->work.executed / 2, unlimited->work.executed - 1}) {
    LiveMesh<D> mesh(DefaultsIn<D>(), tuning);
    one(mesh);
    const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
    apply.max_operations = most;
    const auto limited = mesh.Apply(AddAll(scene), apply);
    if (limited.ok()) {  // there was no room for a build, and it was propagated to the end
      EXPECT_NE(tuning.rebuild.at_least_work, AlwaysPropagate().rebuild.at_least_work);
      EXPECT_LE(limited->work.executed, most);
      EXPECT_EQ(limited->hash, unlimited->hash);
      continue;
    }
    ASSERT_EQ(limited.status().code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(GetErrorDetail(limited.status())->reason, reason::kWorkLimit);
    EXPECT_EQ(mesh.revision(), 1u);
    EXPECT_EQ(mesh.Features().size(), 1u);
    EXPECT_EQ(mesh.hash(), hash);
    EXPECT_EQ(mesh.Audit().trace, trace);
    // The refused batch may have left smaller cells, in which more operations are found stale.
    apply.max_operations = unlimited->work.executed + unlimited->work.executed / 100;
    const auto diff = mesh.Apply(AddAll(scene), apply);
    ASSERT_TRUE(diff.ok()) << diff.status();
    EXPECT_EQ(diff->hash, unlimited->hash);
  }
}

TEST(WorkLimit, UndoesABatchThatNeedsMore) {
  for (const LiveMeshTuning& tuning : {AlwaysPropagate(), LiveMeshTuning(), GivesUpAfter(40)}) {
    ExpectTheWorkLimitToHold<2>(Comb(10), tuning);
    ExpectTheWorkLimitToHold<2>(
        {Feature::SizeDisc(1, 0.5, 0.5, 0.2, 0.01), Feature::Point(2, 0.1, 0.1)}, tuning);
    ExpectTheWorkLimitToHold<3>(Slab(0.05), tuning);
  }
}

TEST(WorkLimit, HoldsForACreationToo) {
  MeshOptions options;
  options.max_edge = 0.01;
  ApplyOptions apply;
  apply.max_operations = 100;
  const auto refused = DynamicMesh::Create(options, apply);
  ASSERT_EQ(refused.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(GetErrorDetail(refused.status())->reason, reason::kWorkLimit);
  apply.max_operations = 1'000'000;
  EXPECT_TRUE(DynamicMesh::Create(options, apply).ok());
}

}  // namespace
}  // namespace dynmesh::test::fallback_test
