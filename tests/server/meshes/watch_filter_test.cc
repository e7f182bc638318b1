// A filtered watch: a replica of the filtered items always equals the filtered mesh.
#include "server/meshes/watch_filter.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "dynmesh/slot_mesh.h"
#include "tests/server/test_support.h"

namespace dynmesh::server::watch_filter_test {
namespace {

Mesh Sorted(Mesh mesh) {
  Canonicalize(mesh);
  return mesh;
}

class WatchFilterTest : public ::testing::Test {
 protected:
  // Hub and subscription hold each other until then.
  void TearDown() override { subscription_->Cancel(); }
  void Begin(const mesh_data::RegionChoice& choice, RevisionStore::Limits limits,
             WatchHub::Options options) {
    choice_ = choice;
    store_ =
        std::make_shared<RevisionStore>(std::make_shared<const Mesh>(fake_.Snapshot()), limits);
    hub_ = WatchHub::Create(store_, &pool_, options);
    subscription_ = *hub_->Subscribe({.progress_interval = absl::Seconds(1)}, [] {});
    filter_ = std::make_unique<WatchFilter>(choice);
  }
  void Publish(const EditBatch& batch) {
    auto diff = fake_.Apply(batch, {});
    ASSERT_TRUE(diff.ok()) << Text(diff.status());
    ASSERT_TRUE(store_->Append(std::make_shared<const MeshDiff>(*std::move(diff))).ok());
    hub_->Notify();
  }
  // Takes all there is.
  void Drain() {
    WatchItem item;
    for (;;) {
      const Subscription::Step step = subscription_->Next(&item);
      if (step == Subscription::Step::kIdle) return;
      if (step == Subscription::Step::kWork) item = subscription_->Work();
      Take(filter_->Apply(item));
    }
  }
  void Take(const WatchItem& item) {
    if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&item)) {
      auto store = SlotMesh::FromMesh(**mesh);
      ASSERT_TRUE(store.ok()) << Text(store.status());
      replica_ = *std::move(store);
      ++snapshots_;
    } else if (const auto* diff = std::get_if<std::shared_ptr<const MeshDiff>>(&item)) {
      const absl::Status status = replica_.Apply(**diff);
      ASSERT_TRUE(status.ok()) << Text(status);
      coalesced_ += (*diff)->to_revision > (*diff)->from_revision + 1;
    } else if (const auto* head = std::get_if<Head>(&item)) {
      EXPECT_EQ(head->revision, replica_.revision());
      EXPECT_EQ(head->hash, replica_.hash());
      ++progress_;
    } else {
      ADD_FAILURE() << "the watch ended";
    }
  }
  void ExpectThePart() {
    const Mesh part = Sorted(mesh_data::SimplicesInside(fake_.Snapshot(), choice_));
    const Mesh got = Sorted(replica_.ToMesh());
    EXPECT_EQ(got.revision, part.revision);
    EXPECT_EQ(got.vertices, part.vertices);
    EXPECT_EQ(got.simplices, part.simplices);
    EXPECT_EQ(got.regions, part.regions);
    EXPECT_EQ(got.region_sets, part.region_sets);
    EXPECT_EQ(got.subsegments, part.subsegments);
    EXPECT_EQ(got.subfacets, part.subfacets);
    EXPECT_EQ(got.hash, part.hash);
  }
  // Points 1 to 12 and polygons 101 to 103 around some of them.
  EditBatch AnyEdits(std::mt19937_64& random) {
    EditBatch batch;
    if (fake_.revision() == 0) {
      for (FeatureId id = 1; id <= 12; ++id) batch.push_back(AddPoint(id));
      return batch;
    }
    const FeatureId polygon = 101 + random() % 3;
    std::vector<FeatureId> ring;
    for (FeatureId id = 1 + random() % 8; id <= 12 && ring.size() < 3 + random() % 6; ++id) {
      ring.push_back(id);
    }
    const bool present = polygons_.contains(polygon);
    if (present && random() % 3 == 0) {
      polygons_.erase(polygon);
      return {Edit::Remove(polygon)};
    }
    polygons_.insert(polygon);
    const Feature feature = Feature::Polygon(polygon, {ring});
    batch.push_back(present ? Edit::Set(feature) : Edit::Add(feature));
    batch.push_back(Edit::Move(1 + random() % 12, 0.25, 0.001 * static_cast<double>(++moves_)));
    batch.back().action = Edit::Action::kSet;  // which the fake knows
    return batch;
  }

  WorkerPool pool_{1};
  FakeDynamicMesh fake_{MeshOptions(), nullptr};
  mesh_data::RegionChoice choice_;
  std::shared_ptr<RevisionStore> store_;
  std::shared_ptr<WatchHub> hub_;
  std::shared_ptr<Subscription> subscription_;
  std::unique_ptr<WatchFilter> filter_;
  SlotMesh replica_;
  std::set<FeatureId> polygons_;
  int moves_ = 0;
  int snapshots_ = 0, coalesced_ = 0, progress_ = 0;
};

TEST_F(WatchFilterTest, TheReplicaIsThePartAfterEveryRevision) {
  Begin({{101, 103}, false, {}}, {}, {});
  std::mt19937_64 random(1);
  std::size_t most = 0, some_left_out = 0;
  for (int i = 0; i < 200; ++i) {
    Publish(AnyEdits(random));
    Drain();
    ExpectThePart();
    most = std::max(most, replica_.simplex_count());
    some_left_out += replica_.simplex_count() < fake_.Snapshot().simplex_count();
  }
  EXPECT_EQ(snapshots_, 1);
  EXPECT_GT(most, 3u);
  EXPECT_GT(some_left_out, 10u);
}

TEST_F(WatchFilterTest, WhoLagsGetsThePartOfCoalescedDiffsAndOfNewSnapshots) {
  Begin({{102}, false, {}}, {.revisions = 12}, {.queue = 2});
  std::mt19937_64 random(2);
  for (int i = 0; i < 60; ++i) {
    for (std::uint64_t lag = random() % 16; lag > 0; --lag) Publish(AnyEdits(random));
    if (i % 3 == 0) {
      ASSERT_TRUE(store_->Latest().ok());
    }
    Drain();
    ExpectThePart();
  }
  EXPECT_GT(snapshots_, 2);
  EXPECT_GT(coalesced_, 2);
}

TEST_F(WatchFilterTest, ProgressTellsTheHashOfThePart) {
  Begin({{101}, false, {}}, {}, {});
  std::mt19937_64 random(3);
  absl::Time now = absl::UnixEpoch();
  hub_->Tick(now);
  for (int i = 1; i <= 20; ++i) {
    Publish(AnyEdits(random));
    Drain();
    hub_->Tick(now += absl::Seconds(2));
    Drain();
    EXPECT_EQ(progress_, i);
  }
  ExpectThePart();
}

}  // namespace
}  // namespace dynmesh::server::watch_filter_test
