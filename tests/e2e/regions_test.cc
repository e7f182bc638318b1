// Regions of real meshes over the network: a watcher of some polygons ends with the same mesh as an
// export of them, however far it lagged.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/mesh_data/region_filter.h"
#include "tests/e2e/e2e_fixture.h"
#include "tests/support/same_diff.h"

namespace dynmesh::regions_test {
namespace {

constexpr FeatureId kLeft = 101, kRight = 102, kNone = 999;

// Two squares that overlap in the middle.
EditBatch TwoPolygons() {
  return {Edit::Add(Feature::Point(1, 0.1, 0.1)),
          Edit::Add(Feature::Point(2, 0.6, 0.1)),
          Edit::Add(Feature::Point(3, 0.6, 0.6)),
          Edit::Add(Feature::Point(4, 0.1, 0.6)),
          Edit::Add(Feature::Point(5, 0.7, 0.2)),
          Edit::Add(Feature::Point(6, 0.9, 0.2)),
          Edit::Add(Feature::Point(7, 0.9, 0.5)),
          Edit::Add(Feature::Point(8, 0.7, 0.5)),
          Edit::Add(Feature::Point(9, 0.3, 0.3)),
          Edit::Add(Feature::Point(10, 0.4, 0.3)),
          Edit::Add(Feature::Point(11, 0.4, 0.4)),
          Edit::Add(Feature::Polygon(kLeft, {{1, 2, 3, 4}})),
          Edit::Add(Feature::Polygon(kRight, {{5, 6, 7, 8}, {9, 10, 11}}))};
}

using test::Sorted;

void ExpectSame(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.hash, b.hash);
  test::ExpectSameRows(a, b);
}

TEST_F(EndToEndTest, AWatchOfPolygonsEndsEqualToAnExportOfThem) {
  constexpr std::uint64_t kSeed = 20261121;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0, 1);
  auto local = *DynamicMesh::Create(MeshOptions());
  std::vector<std::vector<FeatureId>> regions = {{kLeft}, {kRight}, {kLeft, kRight}, {kNone}, {}};
  std::vector<std::unique_ptr<client::WatchSession>> watches;
  for (const auto& ids : regions) {
    client::WatchOptions options;
    options.regions = ids;
    watches.push_back(client_->Watch("m", options, nullptr));
  }
  ASSERT_TRUE(client_->Apply("m", TwoPolygons()).ok());
  ASSERT_TRUE(local->Apply(TwoPolygons()).ok());
  const auto session = client_->OpenEdits("m");  // pipelined, so that watchers lag
  std::uint64_t revision = 1;
  for (int round = 0; round < 120; ++round) {
    EditBatch batch;
    switch (round % 6) {
      case 0:  // a corner moves: the border of one region does
        batch = {Edit::Move(3, 0.6 + 0.05 * unit(random), 0.6 + 0.05 * unit(random))};
        break;
      case 1:
        batch = {Edit::Remove(kRight)};
        break;
      case 2:  // labels only: nothing but the polygon changes
        batch = {Edit::Add(Feature::Polygon(kRight, {{5, 6, 7, 8}, {9, 10, 11}}))};
        break;
      default:
        batch = {Edit::Add(
            Feature::Point(1000 + static_cast<FeatureId>(round), unit(random), unit(random)))};
    }
    const auto expected = local->Apply(batch);
    if (!expected.ok()) continue;  // a point on a segment, say: the service refuses it as well
    ASSERT_TRUE(session->Send(batch).ok());
    const auto answer = session->Receive();
    ASSERT_TRUE(answer.has_value() && answer->result.ok()) << answer->result.status();
    EXPECT_EQ(answer->result->diff.hash, expected->hash);
    revision = expected->to_revision;
  }
  ASSERT_GT(revision, 60u);
  const Mesh whole = Sorted(local->Snapshot());
  ASSERT_FALSE(whole.region_sets.empty());
  for (std::size_t i = 0; i < regions.size(); ++i) {
    mesh_data::RegionChoice choice;
    choice.in = regions[i];
    ASSERT_TRUE(watches[i]->WaitForRevision(revision, kLong));
    Mesh replica;
    watches[i]->Read([&](const client::MeshReplica& r) { replica = r.ToMesh(); });
    const auto exported = client_->GetSnapshot("m", regions[i]);
    ASSERT_TRUE(exported.ok()) << exported.status();
    ExpectSame(Sorted(mesh_data::OnlyInside(replica, choice)), Sorted(*exported));
    ExpectSame(Sorted(*exported), Sorted(mesh_data::OnlyInside(whole, choice)));
    EXPECT_EQ(watches[i]->resyncs(), 0);
  }
  EXPECT_EQ(client_->GetSnapshot("m", std::vector{kNone})->simplex_count(), 0u);
  EXPECT_GT(client_->GetSnapshot("m", std::vector{kLeft})->simplex_count(), 10u);
}

}  // namespace
}  // namespace dynmesh::regions_test
