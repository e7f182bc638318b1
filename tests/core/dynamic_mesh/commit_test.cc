// A vetoed batch leaves everything as it was, however it was computed. An accepted one was shown as
// it is returned. Also meshes that resume at a revision.
#include <gtest/gtest.h>

#include <random>

#include "tests/differential/differential.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test::commit_test {
namespace {

constexpr std::uint64_t kSeed = 7;

LiveMeshTuning AlwaysRebuild() {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = 0;
  tuning.rebuild.features = -1;
  return tuning;
}

// The state before `refused`, by all queries.
struct Before {
  explicit Before(const DynamicMesh& mesh)
      : revision(mesh.revision()),
        hash(mesh.hash()),
        audit(mesh.Audit()),
        features(mesh.Features()),
        snapshot(mesh.Snapshot()) {
    Canonicalize(snapshot);
  }
  void ExpectSame(const DynamicMesh& mesh) const {
    const Before now(mesh);
    EXPECT_EQ(now.revision, revision);
    EXPECT_EQ(now.hash, hash);
    EXPECT_EQ(now.audit.trace, audit.trace);
    EXPECT_EQ(now.audit.problems, std::vector<std::string>());
    EXPECT_EQ(now.features, features);
    EXPECT_EQ(now.snapshot.simplices, snapshot.simplices);
    EXPECT_EQ(now.snapshot.regions, snapshot.regions);
    EXPECT_EQ(now.snapshot.vertices, snapshot.vertices);
    EXPECT_EQ(now.snapshot.subsegments, snapshot.subsegments);
    EXPECT_EQ(now.snapshot.subfacets, snapshot.subfacets);
    EXPECT_EQ(now.snapshot.labels, snapshot.labels);
  }
  std::uint64_t revision;
  MeshHash hash;
  AuditReport audit;
  std::vector<Feature> features;
  Mesh snapshot;
};

// Every batch is refused once, then accepted.
template <int D, class Generator>
void ExpectVetoesToChangeNothing(Generator generator, const LiveMeshTuning& tuning, int revisions) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  LiveMesh<D> mesh(DefaultsIn<D>(), tuning);
  for (int revision = 0; revision < revisions;) {
    const EditBatch batch = generator.Next(mesh.Features());
    if (batch.empty() || !mesh.Validate(batch).ok()) continue;
    const Before before(mesh);
    MeshDiff seen;
    ApplyOptions refuse;
    refuse.commit = [&](const MeshDiff& diff) {
      seen = diff;
      return absl::UnavailableError("no");
    };
    const auto refused = mesh.Apply(batch, refuse);
    ASSERT_EQ(refused.status(), absl::UnavailableError("no"));
    before.ExpectSame(mesh);

    ApplyOptions accept;
    int asked = 0;
    accept.commit = [&](const MeshDiff& diff) {
      ++asked;
      EXPECT_EQ(diff.from_revision, before.revision);
      EXPECT_EQ(diff.to_revision, before.revision + 1);
      EXPECT_EQ(diff.hash, seen.hash);
      EXPECT_EQ(diff.work.executed, seen.work.executed);
      return absl::OkStatus();
    };
    const auto diff = mesh.Apply(batch, accept);
    ASSERT_TRUE(diff.ok()) << diff.status();
    EXPECT_EQ(asked, 1);
    // The stages are parts of the whole.
    EXPECT_GT(diff->work.validate_microseconds, 0);
    EXPECT_GT(diff->work.diff_microseconds, 0);
    EXPECT_LE(diff->work.validate_microseconds + diff->work.diff_microseconds,
              diff->work.microseconds);
    EXPECT_EQ(diff->hash, seen.hash);
    EXPECT_EQ(diff->hash, mesh.hash());
    EXPECT_EQ(diff->to_revision, mesh.revision());
    ++revision;
    const Difference d = CompareWithScratch(mesh, true);
    ASSERT_FALSE(d.found) << d.what;
    ASSERT_FALSE(testing::Test::HasFailure());
  }
}

TEST(Commit, ARefusedPropagationIsUndone) {
  for (const Distribution d : {Distribution::kUniform, Distribution::kWedges, Distribution::kSized,
                               Distribution::kSegmentsTurned, Distribution::kPolygons}) {
    SCOPED_TRACE(NameOf(d));
    ExpectVetoesToChangeNothing<2>(ScriptGenerator(d, 20, kSeed), AlwaysPropagate(), 12);
  }
  ExpectVetoesToChangeNothing<3>(ScriptGenerator(Distribution::kSpaceSized, 10, kSeed),
                                 AlwaysPropagate(), 4);
  ExpectVetoesToChangeNothing<3>(PolygonScript(kPolygonKinds[0], 2, kSeed), AlwaysPropagate(), 4);
}

// Polygons far apart, of which one is removed or moves: labels are derived from the changed walls.
TEST(Commit, RegionsComeBackWithARefusedEdit) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0.05, 0.95);
  int tried = 0;
  for (int round = 0; round < 600; ++round) {
    EditBatch load;
    for (FeatureId id = 1; id <= 12; ++id) {
      const double x = unit(random), y = unit(random);
      load.push_back(Edit::Add(Feature::Point(id, x, y)));
    }
    load.push_back(Edit::Add(Feature::Polygon(21, {{1, 2, 3}})));
    load.push_back(Edit::Add(Feature::Polygon(22, {{4, 5, 6}})));
    const double x = unit(random), y = unit(random);
    const EditBatch edit =
        round % 2 == 0 ? EditBatch{Edit::Remove(21)} : EditBatch{Edit::Move(1, x, y)};
    LiveMesh<2> mesh(DefaultsIn<2>(), AlwaysPropagate());
    if (!mesh.Apply(load, ApplyOptions()).ok() || !mesh.Validate(edit).ok()) continue;
    ++tried;
    const Before before(mesh);
    ApplyOptions refuse;
    refuse.commit = [](const MeshDiff&) { return absl::UnavailableError("no"); };
    ASSERT_TRUE(absl::IsUnavailable(mesh.Apply(edit, refuse).status()));
    before.ExpectSame(mesh);
    ASSERT_FALSE(testing::Test::HasFailure()) << "round " << round;
  }
  EXPECT_GT(tried, 100);
}

TEST(Commit, ARefusedRebuildIsUndone) {
  for (const Distribution d : {Distribution::kUniform, Distribution::kPolygons}) {
    SCOPED_TRACE(NameOf(d));
    ExpectVetoesToChangeNothing<2>(ScriptGenerator(d, 20, kSeed), AlwaysRebuild(), 10);
    // Sooner or later either way, and both in one batch.
    ExpectVetoesToChangeNothing<2>(ScriptGenerator(d, 60, kSeed), LiveMeshTuning(), 10);
  }
  ExpectVetoesToChangeNothing<3>(ScriptGenerator(Distribution::kSpaceUniform, 8, kSeed),
                                 AlwaysRebuild(), 3);
}

TEST(Commit, ABatchThatWasFoundMostlyStaleOnTheWayIsUndone) {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = 1;
  tuning.rebuild.stale = 0;
  ExpectVetoesToChangeNothing<2>(ScriptGenerator(Distribution::kUniform, 40, kSeed), tuning, 12);
}

TEST(Commit, IsNotAskedForWhatIsRefusedAnyway) {
  const auto mesh = *DynamicMesh::Create(MeshOptions());
  ApplyOptions options;
  options.commit = [](const MeshDiff&) {
    ADD_FAILURE() << "asked";
    return absl::OkStatus();
  };
  EXPECT_FALSE(mesh->Apply({Edit::Remove(1)}, options).ok());
  const EditBatch batch = {Edit::Add(Feature::Point(1, 0.5, 0.5))};
  options.interrupted = [] { return true; };
  EXPECT_TRUE(absl::IsCancelled(mesh->Apply(batch, options).status()));
  options.interrupted = [] { return false; };
  options.commit = nullptr;
  EXPECT_TRUE(mesh->Apply(batch, options).ok());
}

TEST(Commit, IsAskedForAnEmptyBatch) {
  const auto mesh = *DynamicMesh::Create(MeshOptions());
  ApplyOptions options;
  options.commit = [](const MeshDiff& diff) {
    EXPECT_EQ(diff.from_revision, diff.to_revision);
    return absl::UnavailableError("no");
  };
  EXPECT_TRUE(absl::IsUnavailable(mesh->Apply({}, options).status()));
}

TEST(ResumeAt, ChangesTheNumberAndNothingElse) {
  const std::vector<Feature> features = MakeFeatures(Distribution::kUniform, 30, kSeed);
  const auto mesh = *DynamicMesh::Create(MeshOptions());
  ASSERT_TRUE(mesh->Apply(AddAll(features)).ok());
  const MeshHash hash = mesh->hash(), trace = mesh->Audit().trace;
  mesh->ResumeAt(41);
  EXPECT_EQ(mesh->revision(), 41u);
  EXPECT_EQ(mesh->Snapshot().revision, 41u);
  EXPECT_EQ(mesh->Stats().revision, 41u);
  EXPECT_EQ(mesh->hash(), hash);
  EXPECT_EQ(mesh->Audit().trace, trace);
  const auto diff = mesh->Apply({Edit::Remove(features.front().id)});
  ASSERT_TRUE(diff.ok());
  EXPECT_EQ(diff->from_revision, 41u);
  EXPECT_EQ(diff->to_revision, 42u);
}

}  // namespace
}  // namespace dynmesh::test::commit_test
