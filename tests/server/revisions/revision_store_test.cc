// Snapshots and history of one mesh, and the diff algebra.
#include "server/revisions/revision_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/mesh_data/diff_meshes.h"
#include "server/revisions/diff_algebra.h"
#include "tests/core/mesh_data/made_up_mesh.h"
#include "tests/server/test_support.h"
#include "tests/support/crafted.h"
#include "tests/support/same_diff.h"

namespace dynmesh::server::revision_store_test {
namespace {

// A random walk of a fake mesh: the mesh and the diff of every revision.
struct Walk {
  std::vector<std::shared_ptr<const Mesh>> meshes;  // by revision
  std::vector<std::shared_ptr<const MeshDiff>> diffs;
};

Walk MakeWalk(std::uint64_t seed, int length) {
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  FakeDynamicMesh fake(MeshOptions(), nullptr);
  Walk walk;
  walk.meshes.push_back(std::make_shared<Mesh>(fake.Snapshot()));
  std::set<FeatureId> points, segments, polygons;
  FeatureId next_segment = 1000;
  for (int i = 0; i < length; ++i) {
    EditBatch batch;
    for (std::uint64_t k = random() % 4 + 1; k > 0; --k) {
      const FeatureId id = random() % 20 + 1;
      const FeatureId polygon = 2001 + random() % 4;
      if (points.size() > 5 && random() % 3 == 0) {
        // Relabels the triangles between two points, or more, or fewer.
        const auto first = std::next(points.begin(), static_cast<int>(random() % 3));
        const Feature feature = Feature::Polygon(polygon, {{first, points.end()}});
        const bool present = !polygons.insert(polygon).second;
        batch.push_back(present ? Edit::Set(feature) : Edit::Add(feature));
        continue;
      }
      if (points.size() > 2 && random() % 4 == 0) {
        const FeatureId p = *points.begin(), q = *points.rbegin();
        batch.push_back(Edit::Add(Feature::Segment(next_segment, p, q)));
        segments.insert(next_segment++);
      } else if (!points.contains(id)) {
        batch.push_back(AddPoint(id));
        points.insert(id);
      } else if (segments.empty()) {
        for (const FeatureId p : polygons) batch.push_back(Edit::Remove(p));
        polygons.clear();
        batch.push_back(Edit::Remove(id));
        points.erase(id);
      } else {
        batch.push_back(Edit::Remove(*segments.begin()));
        segments.erase(segments.begin());
      }
    }
    auto diff = fake.Apply(batch, {});
    EXPECT_TRUE(diff.ok()) << Text(diff.status());
    if (!diff.ok()) break;
    walk.diffs.push_back(std::make_shared<MeshDiff>(*std::move(diff)));
    walk.meshes.push_back(std::make_shared<Mesh>(fake.Snapshot()));
  }
  return walk;
}

// A walk to and fro between a few made-up meshes, in which owners and regions change.
Walk MakeUpWalk(std::uint64_t seed, int length, int dimension) {
  std::mt19937_64 random(seed);
  std::vector<Mesh> places;
  for (int i = 0; i < 3; ++i) places.push_back(testing::MakeUpMesh(random, 30, 0, dimension));
  Walk walk;
  for (int i = 0; i <= length; ++i) {
    Mesh mesh = places[random() % 3];
    mesh.revision = static_cast<std::uint64_t>(i);
    for (auto* owners : {&mesh.subsegments.owners, &mesh.subfacets.owners}) {
      if (!owners->empty()) (*owners)[random() % 3] = 7 + random() % 2;
    }
    testing::Label(random, mesh);
    mesh.labels = testing::AnyLabels(random);
    if (i > 0) {
      walk.diffs.push_back(
          std::make_shared<MeshDiff>(mesh_data::DiffMeshes(*walk.meshes.back(), mesh)));
    }
    walk.meshes.push_back(std::make_shared<Mesh>(mesh));
  }
  return walk;
}

void ExpectSameMesh(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.revision, b.revision);
  test::ExpectSameRows(test::Sorted(a), test::Sorted(b));
  EXPECT_EQ(a.hash, b.hash);
}

TEST(DiffAlgebra, TheWalkGoesThroughRegions) {
  const Walk walk = MakeWalk(1, 40);
  int relabelled = 0, sets = 0, idle = 0;
  for (const auto& diff : walk.diffs) {
    for (std::size_t i = 0; i < diff->removed_simplex_count(); ++i) {
      const auto row = diff->removed_simplices.begin() + static_cast<std::ptrdiff_t>(3 * i);
      const auto& added = diff->added_simplices;
      relabelled += std::search(added.begin(), added.end(), row, row + 3) != added.end();
    }
    sets += !diff->region_sets.empty();
  }
  for (const auto& mesh : walk.meshes) idle += mesh->regions.empty();
  EXPECT_GT(relabelled, 10);
  EXPECT_GT(sets, 2);
  EXPECT_GT(idle, 0);
}

TEST(DiffAlgebra, ASimplexThatComesBackToItsRegionCancels) {
  FakeDynamicMesh fake(MeshOptions(), nullptr);
  ASSERT_TRUE(fake.Apply({AddPoint(1), AddPoint(2), AddPoint(3)}, {}).ok());
  std::vector<std::shared_ptr<const MeshDiff>> diffs;
  const Feature polygon = Feature::Polygon(9, {{1, 2, 3}});
  for (const Edit& edit : {Edit::Add(polygon), Edit::Remove(9)}) {
    auto diff = fake.Apply({edit}, {});
    ASSERT_TRUE(diff.ok());
    EXPECT_EQ(diff->added_simplex_count(), 1u);
    diffs.push_back(std::make_shared<MeshDiff>(*diff));
  }
  const MeshDiff both = Compose(diffs);
  EXPECT_EQ(both.added_simplex_count() + both.removed_simplex_count(), 0u);
  EXPECT_TRUE(both.added_regions.empty() && both.removed_regions.empty());
}

// Two sets of polygons with the same id, as a client can choose: each revision has the right one,
// and so does any composition of diffs.
TEST(DiffAlgebra, AnIdThatComesToStandForAnotherSetStandsForTheLast) {
  const std::vector<FeatureId> one = {1, 2};
  const std::vector<FeatureId> other = test::AnyPairOfRegionId(RegionIdOf(one), 3);
  ASSERT_EQ(RegionIdOf(one), RegionIdOf(other));
  std::mt19937_64 random(7);
  Mesh bare = dynmesh::testing::MakeUpMesh(random, 30, 0);
  Canonicalize(bare);
  std::vector<Mesh> meshes;
  for (const std::vector<FeatureId>& set : {one, {}, other, one}) {
    Mesh mesh = bare;
    mesh.revision = meshes.size();
    if (!set.empty()) {
      mesh.regions.assign(mesh.simplex_count(), kNoRegion);
      mesh.regions[3] = mesh.regions[7] = RegionIdOf(set);
      mesh.region_sets = {{RegionIdOf(set), set}};
    }
    mesh.hash = ComputeHash(mesh);
    meshes.push_back(mesh);
  }
  std::vector<std::shared_ptr<const MeshDiff>> diffs;
  for (std::size_t i = 1; i < meshes.size(); ++i) {
    diffs.push_back(std::make_shared<MeshDiff>(mesh_data::DiffMeshes(meshes[i - 1], meshes[i])));
  }
  for (std::size_t from = 0; from < meshes.size(); ++from) {
    for (std::size_t to = from + 1; to < meshes.size(); ++to) {
      SCOPED_TRACE(::testing::Message() << from << " to " << to);
      const auto at = [&](std::size_t i) { return diffs.begin() + static_cast<std::ptrdiff_t>(i); };
      for (const MeshDiff& diff :
           {Compose({at(from), at(to)}), mesh_data::DiffMeshes(meshes[from], meshes[to])}) {
        Mesh followed = meshes[from];
        ASSERT_EQ(ApplyDiff(followed, diff), absl::OkStatus());
        ExpectSameMesh(followed, meshes[to]);
        const auto patched = Patched(meshes[from], diff);
        ASSERT_EQ(patched.status(), absl::OkStatus());
        ExpectSameMesh(*patched, meshes[to]);
      }
    }
  }
}

TEST(DiffAlgebra, SizesCountRegionsAndTheirSets) {
  Mesh mesh;
  mesh.simplices = {1, 2, 3, 1, 3, 4};
  const std::size_t bare = ByteSize(mesh);
  mesh.regions = {7, 8};
  EXPECT_EQ(ByteSize(mesh), bare + 16);
  mesh.region_sets = {{5, {1, 2, 3}}};
  EXPECT_GE(ByteSize(mesh), bare + 16 + 32);
  MeshDiff diff;
  const std::size_t empty = ByteSize(diff);
  diff.removed_regions = {7};
  diff.added_regions = {7, 8};
  EXPECT_EQ(ByteSize(diff), empty + 24);
  diff.region_sets = mesh.region_sets;
  EXPECT_GE(ByteSize(diff), empty + 24 + 32);
  mesh = Mesh();
  mesh.subfacets = {{1, 2, 3}, {4}};
  EXPECT_EQ(ByteSize(mesh), ByteSize(Mesh()) + 32);
  mesh = Mesh();
  mesh.labels = {{1, {2, "abc"}}};
  EXPECT_EQ(ByteSize(mesh), ByteSize(Mesh()) + sizeof(LabelOfFeature) + 3);
  diff = MeshDiff();
  diff.labels = mesh.labels;
  EXPECT_EQ(ByteSize(diff), empty + sizeof(LabelOfFeature) + 3);
  mesh.subfacets = {{1, 2, 3}, {4}};
  diff = MeshDiff();
  diff.added_subfacets = diff.removed_subfacets = mesh.subfacets;
  EXPECT_EQ(ByteSize(diff), empty + 64);
}

void CheckComposition(const Walk& walk) {
  for (std::size_t from = 0; from < walk.diffs.size(); from += 3) {
    for (std::size_t to = from + 1; to <= walk.diffs.size(); to += 5) {
      const MeshDiff diff = Compose({walk.diffs.begin() + static_cast<std::ptrdiff_t>(from),
                                     walk.diffs.begin() + static_cast<std::ptrdiff_t>(to)});
      // The library's own ApplyDiff checks it: every row and the hash.
      Mesh mesh = *walk.meshes[from];
      const absl::Status status = ApplyDiff(mesh, diff);
      ASSERT_TRUE(status.ok()) << from << ".." << to << ": " << Text(status);
      ExpectSameMesh(mesh, *walk.meshes[to]);
      const auto patched = Patched(*walk.meshes[from], diff);
      ASSERT_TRUE(patched.ok());
      ExpectSameMesh(*patched, *walk.meshes[to]);
    }
  }
}

TEST(DiffAlgebra, AnySpanOfDiffsComposesToTheDifferenceOfItsEnds) {
  CheckComposition(MakeWalk(1, 40));
  for (const int dimension : testing::kDimensions) {
    const Walk walk = MakeUpWalk(7, 30, dimension);
    CheckComposition(walk);
    // Subfacets that come and go again cancel.
    if (dimension == 2) continue;
    std::size_t rows = 0;
    for (const auto& diff : walk.diffs) rows += diff->added_subfacets.size();
    EXPECT_GT(rows, 200u);
    EXPECT_LE(Compose(walk.diffs).added_subfacets.size(), 15u);
  }
}

// Of each feature the last label counts, also if it has none in the end.
TEST(DiffAlgebra, LabelsOfJoinedDiffsAreTheLast) {
  std::vector<std::shared_ptr<const MeshDiff>> diffs;
  const LabelColumn columns[] = {{{1, {1, ""}}, {2, {0, "b"}}, {9, {9, ""}}},
                                 {{2, {}}, {3, {3, "c"}}},
                                 {{1, {1, "a"}}, {3, {}}}};
  for (std::uint64_t i = 0; i < 3; ++i) {
    auto diff = std::make_shared<MeshDiff>();
    diff->from_revision = i, diff->to_revision = i + 1;
    diff->labels = columns[i];
    diffs.push_back(diff);
  }
  EXPECT_EQ(Compose(diffs).labels, (LabelColumn{{1, {1, "a"}}, {2, {}}, {3, {}}, {9, {9, ""}}}));
}

TEST(DiffAlgebra, AVertexThatChangesOwnerTwiceEndsWithTheLast) {
  // Point 1 is replaced by point 2 in the same place, then by point 3.
  FakeDynamicMesh fake(MeshOptions(), nullptr);
  ASSERT_TRUE(fake.Apply({Edit::Add(Feature::Point(1, 0.5, 0.5))}, {}).ok());
  Mesh mesh = fake.Snapshot();
  std::vector<std::shared_ptr<const MeshDiff>> diffs;
  for (FeatureId id = 2; id <= 3; ++id) {
    auto diff = fake.Apply({Edit::Remove(id - 1), Edit::Add(Feature::Point(id, 0.5, 0.5))}, {});
    ASSERT_TRUE(diff.ok());
    ASSERT_EQ(diff->removed_vertices.size(), 1u);
    diffs.push_back(std::make_shared<MeshDiff>(*diff));
  }
  const MeshDiff both = Compose(diffs);
  EXPECT_EQ(both.removed_vertices.size(), 1u);
  ASSERT_EQ(both.added_vertices.size(), 1u);
  EXPECT_EQ(both.added_vertices.owners[0], 3u);
  EXPECT_TRUE(ApplyDiff(mesh, both).ok());
}

TEST(DiffAlgebra, PatchingAnotherMeshIsRefused) {
  const Walk walk = MakeWalk(2, 5);
  EXPECT_EQ(Patched(*walk.meshes[0], *walk.diffs[1]).status().code(),
            absl::StatusCode::kFailedPrecondition);
  MeshDiff stray = *walk.diffs[0];
  stray.removed_vertices.push_back(12345);
  EXPECT_EQ(Patched(*walk.meshes[0], stray).status().code(), absl::StatusCode::kDataLoss);
  const Walk space = MakeUpWalk(2, 1, 3);
  stray = *space.diffs[0];
  ASSERT_TRUE(Patched(*space.meshes[0], stray).ok());
  mesh_data::Append(stray.removed_subfacets, {1, 2, 3, 4});
  EXPECT_EQ(Patched(*space.meshes[0], stray).status().code(), absl::StatusCode::kDataLoss);
}

TEST(RevisionStore, TheLatestMeshIsThatOfTheHeadAfterEveryRevision) {
  for (const Walk& walk : {MakeWalk(3, 30), MakeUpWalk(3, 30, 3)}) {
    RevisionStore store(walk.meshes[0], {});
    for (std::size_t i = 0; i < walk.diffs.size(); ++i) {
      ASSERT_TRUE(store.Append(walk.diffs[i]).ok());
      EXPECT_EQ(store.head().revision, i + 1);
      EXPECT_EQ(store.head().hash, walk.meshes[i + 1]->hash);
      if (i % 4 == 3) {
        const auto mesh = store.Latest();
        ASSERT_TRUE(mesh.ok());
        ExpectSameMesh(**mesh, *walk.meshes[i + 1]);
        EXPECT_EQ(store.base(), *mesh);
        // Nothing came since: the same object, no work.
        EXPECT_EQ(*store.Latest(), *mesh);
      }
    }
  }
}

TEST(RevisionStore, ASnapshotThatIsReadDoesNotChange) {
  const Walk walk = MakeWalk(4, 10);
  RevisionStore store(walk.meshes[0], {});
  ASSERT_TRUE(store.Append(walk.diffs[0]).ok());
  const auto early = *store.Latest();
  for (std::size_t i = 1; i < walk.diffs.size(); ++i) ASSERT_TRUE(store.Append(walk.diffs[i]).ok());
  ASSERT_TRUE(store.Latest().ok());
  ExpectSameMesh(*early, *walk.meshes[1]);
}

TEST(RevisionStore, AGapIsRefused) {
  const Walk walk = MakeWalk(5, 3);
  RevisionStore store(walk.meshes[0], {});
  EXPECT_EQ(store.Append(walk.diffs[1]).code(), absl::StatusCode::kFailedPrecondition);
  ASSERT_TRUE(store.Append(walk.diffs[0]).ok());
  EXPECT_EQ(store.Append(walk.diffs[0]).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(store.head().revision, 1u);
}

// It would be held for as long as nothing else is edited.
TEST(RevisionStore, ABaseOfWhichMostIsGoneIsNotKept) {
  FakeDynamicMesh fake(MeshOptions(), nullptr);
  EditBatch all, most;
  for (FeatureId id = 1; id <= 20'000; ++id) {
    all.push_back(AddPoint(id));
    if (id > 100) most.push_back(Edit::Remove(id));
  }
  ASSERT_TRUE(fake.Apply(all, {}).ok());
  RevisionStore store(std::make_shared<Mesh>(fake.Snapshot()), {});
  EXPECT_FALSE(store.wants_rebase());
  auto diff = fake.Apply(most, {});
  ASSERT_TRUE(diff.ok());
  ASSERT_LT(ByteSize(*diff), ByteSize(*store.base()));  // so that does not tell
  ASSERT_TRUE(store.Append(std::make_shared<MeshDiff>(*std::move(diff))).ok());
  EXPECT_TRUE(store.wants_rebase());
  ASSERT_TRUE(store.Latest().ok());
  EXPECT_FALSE(store.wants_rebase());
  EXPECT_LT(ByteSize(*store.base()), 100'000u);
}

TEST(RevisionStore, HistoryIsBoundedButReachesBackToTheBase) {
  const Walk walk = MakeWalk(6, 50);
  RevisionStore store(walk.meshes[0], {5, 1 << 30});
  for (const auto& diff : walk.diffs) ASSERT_TRUE(store.Append(diff).ok());
  // The base is at 0, so all that leads from it is held, and a new base is wanted.
  EXPECT_EQ(store.oldest(), 0u);
  EXPECT_TRUE(store.wants_rebase());
  ASSERT_TRUE(store.Latest().ok());
  EXPECT_FALSE(store.wants_rebase());
  EXPECT_EQ(store.oldest(), 45u);
  EXPECT_EQ(store.DiffFrom(44), nullptr);
  EXPECT_EQ(store.DiffFrom(45), walk.diffs[45]);
  EXPECT_EQ(store.DiffFrom(50), nullptr);
  EXPECT_FALSE(store.DiffsFrom(44).has_value());
  EXPECT_EQ(store.DiffsFrom(45)->size(), 5u);
  EXPECT_TRUE(store.DiffsFrom(50)->empty());
  EXPECT_FALSE(store.DiffsFrom(51).has_value());
  EXPECT_FALSE(store.HashAt(44).has_value());
  for (std::size_t r = 45; r <= 50; ++r) EXPECT_EQ(store.HashAt(r), walk.meshes[r]->hash);
}

TEST(RevisionStore, TheNewestDiffIsKeptHoweverLarge) {
  const Walk walk = MakeWalk(7, 3);
  RevisionStore store(walk.meshes[0], {100, 1});
  for (const auto& diff : walk.diffs) {
    ASSERT_TRUE(store.Append(diff).ok());
    ASSERT_TRUE(store.Latest().ok());
  }
  EXPECT_EQ(store.oldest(), 2u);
  EXPECT_NE(store.DiffFrom(2), nullptr);
}

}  // namespace
}  // namespace dynmesh::server::revision_store_test
