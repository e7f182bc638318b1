// Watches, by the list of their possible faults: revisions lost or sent twice, lost wake-ups, older
// states, future and compacted starts, slow watchers.
#include "server/meshes/watch_hub.h"

#include <gtest/gtest.h>

#include <thread>

#include "dynmesh/slot_mesh.h"
#include "server/revisions/diff_algebra.h"
#include "tests/server/test_support.h"

namespace dynmesh::server::watch_hub_test {
namespace {

class WatchHubTest : public ::testing::Test {
 protected:
  void Begin(RevisionStore::Limits limits = {}, WatchHub::Options options = {}) {
    store_ =
        std::make_shared<RevisionStore>(std::make_shared<const Mesh>(fake_.Snapshot()), limits);
    hub_ = WatchHub::Create(store_, &pool_, options);
  }
  void Publish(const EditBatch& batch) {
    auto diff = fake_.Apply(batch, {});
    ASSERT_TRUE(diff.ok()) << Text(diff.status());
    ASSERT_TRUE(store_->Append(std::make_shared<const MeshDiff>(*std::move(diff))).ok());
    hub_->Notify();
  }
  void PublishPoints(FeatureId first, FeatureId last) {
    for (FeatureId id = first; id <= last; ++id) Publish({AddPoint(id)});
  }

  WorkerPool pool_{2};
  FakeDynamicMesh fake_{MeshOptions(), nullptr};
  std::shared_ptr<RevisionStore> store_;
  std::shared_ptr<WatchHub> hub_;
};

// A watcher that takes what there is into a replica, which refuses any gap, repetition
// or damage.
class TestWatcher {
 public:
  TestWatcher(WatchHub& hub, const WatchHub::Start& start, const Mesh& held = Mesh()) {
    // A wake-up may still be under way when the watcher is gone.
    auto s = hub.Subscribe(start, [wakes = wakes_] { wakes->Put(0); });
    EXPECT_TRUE(s.ok()) << Text(s.status());
    subscription_ = *s;
    if (start.revision.has_value()) replica_ = *SlotMesh::FromMesh(held);
  }
  ~TestWatcher() { subscription_->Cancel(); }

  // Takes items until there is nothing, or `limit` of them.
  void Drain(int limit = 1 << 30) {
    WatchItem item;
    for (; limit > 0; --limit) {
      switch (subscription_->Next(&item)) {
        case Subscription::Step::kIdle:
          return;
        case Subscription::Step::kWork:
          ++works_;
          item = subscription_->Work();
          break;
        case Subscription::Step::kItem:
          break;
      }
      Take(item);
    }
  }
  void WaitForWake() { wakes_->Take(); }
  std::size_t untaken_wakes() { return wakes_->size(); }

  void Take(const WatchItem& item) {
    if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&item)) {
      EXPECT_TRUE(!replica_.has_value() || (*mesh)->revision > replica_->revision())
          << "time travel";
      replica_ = *SlotMesh::FromMesh(**mesh);
      ++snapshots_;
    } else if (const auto* diff = std::get_if<std::shared_ptr<const MeshDiff>>(&item)) {
      ASSERT_TRUE(replica_.has_value());
      const absl::Status status = replica_->Apply(**diff);
      EXPECT_TRUE(status.ok()) << Text(status);
      steps_.push_back((*diff)->to_revision - (*diff)->from_revision);
    } else if (const auto* head = std::get_if<Head>(&item)) {
      EXPECT_EQ(head->revision, replica_->revision());
      EXPECT_EQ(head->hash, replica_->hash());
      ++progress_;
    } else {
      end_ = std::get<absl::Status>(item);
    }
  }

  std::optional<SlotMesh> replica_;
  std::vector<std::uint64_t> steps_;  // revisions that each diff covered
  int snapshots_ = 0, works_ = 0, progress_ = 0;
  std::optional<absl::Status> end_;
  const std::shared_ptr<Mailbox<int>> wakes_ = std::make_shared<Mailbox<int>>();
  std::shared_ptr<Subscription> subscription_;
};

TEST_F(WatchHubTest, AWatcherGetsTheMeshThenEveryRevisionOnce) {
  Begin();
  TestWatcher watcher(*hub_, {});
  watcher.Drain();
  EXPECT_EQ(watcher.snapshots_, 1);
  for (FeatureId id = 1; id <= 20; ++id) {
    PublishPoints(id, id);
    watcher.WaitForWake();
    watcher.Drain();
    EXPECT_EQ(watcher.replica_->revision(), id);
  }
  EXPECT_EQ(watcher.steps_, std::vector<std::uint64_t>(20, 1));
  EXPECT_EQ(watcher.replica_->hash(), store_->head().hash);
}

TEST_F(WatchHubTest, AWakeUpComesOnceForManyRevisions) {
  Begin();
  TestWatcher watcher(*hub_, {});
  watcher.Drain();
  PublishPoints(1, 10);
  watcher.WaitForWake();
  EXPECT_EQ(watcher.untaken_wakes(), 0u);
  watcher.Drain();
  EXPECT_EQ(watcher.steps_, std::vector<std::uint64_t>(10, 1));
}

TEST_F(WatchHubTest, AStartInThePastGetsEachRevisionSinceHoweverMany) {
  Begin({}, {.queue = 4});
  PublishPoints(1, 5);
  const Mesh held = fake_.Snapshot();
  PublishPoints(6, 60);
  TestWatcher watcher(*hub_, {.revision = 5, .hash = held.hash}, held);
  watcher.Drain();
  EXPECT_EQ(watcher.snapshots_, 0);
  EXPECT_EQ(watcher.steps_, std::vector<std::uint64_t>(55, 1));
  EXPECT_EQ(watcher.replica_->hash(), store_->head().hash);
}

TEST_F(WatchHubTest, AStartAtTheHeadWaits) {
  Begin();
  PublishPoints(1, 3);
  TestWatcher watcher(*hub_, {.revision = 3}, fake_.Snapshot());
  watcher.Drain();
  EXPECT_TRUE(watcher.steps_.empty());
  EXPECT_EQ(hub_->idle(), 1u);
  PublishPoints(4, 4);
  watcher.WaitForWake();
  watcher.Drain();
  EXPECT_EQ(watcher.steps_.size(), 1u);
}

TEST_F(WatchHubTest, AFutureStartIsRefused) {
  Begin();
  PublishPoints(1, 3);
  const auto s = hub_->Subscribe({.revision = 4}, [] {});
  EXPECT_EQ(s.status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(ReasonOf(s.status()), codec::reason::kFutureRevision);
  EXPECT_EQ(codec::GetServiceError(s.status())->metadata["revision"], "3");
  EXPECT_EQ(hub_->size(), 0u);
}

TEST_F(WatchHubTest, ACompactedStartIsRefusedWithTheOldestRevision) {
  Begin({.revisions = 2});
  PublishPoints(1, 5);
  ASSERT_TRUE(store_->Latest().ok());
  const auto s = hub_->Subscribe({.revision = 2}, [] {});
  EXPECT_EQ(s.status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(ReasonOf(s.status()), codec::reason::kCompacted);
  EXPECT_EQ(codec::GetServiceError(s.status())->metadata["oldest_revision"], "3");
  EXPECT_TRUE(hub_->Subscribe({.revision = 3}, [] {}).ok());
}

TEST_F(WatchHubTest, AStartFromAnotherPastIsRefused) {
  Begin();
  PublishPoints(1, 3);
  const auto s = hub_->Subscribe({.revision = 2, .hash = MeshHash{1, 2}}, [] {});
  EXPECT_EQ(s.status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(ReasonOf(s.status()), codec::reason::kDiverged);
}

TEST_F(WatchHubTest, ASlowWatcherGetsCoalescedDiffs) {
  Begin({}, {.queue = 4});
  Publish({AddPoint(1001), AddPoint(1002), AddPoint(1003), AddPoint(1004)});
  ASSERT_TRUE(store_->Latest().ok());
  TestWatcher watcher(*hub_, {});
  watcher.Drain();
  EXPECT_EQ(watcher.snapshots_, 1);
  // Edits that undo each other: what is left is small, whatever went on between.
  for (int i = 0; i < 30; ++i) {
    Publish({AddPoint(7)});
    Publish({Edit::Remove(7)});
  }
  watcher.Drain();
  EXPECT_EQ(watcher.steps_, std::vector<std::uint64_t>{60});
  EXPECT_EQ(watcher.snapshots_, 1);
  EXPECT_EQ(hub_->counts().coalesced, 1u);
  EXPECT_EQ(hub_->counts().resynced, 0u);
  EXPECT_EQ(watcher.replica_->hash(), store_->head().hash);
}

TEST_F(WatchHubTest, AWatcherWithinTheQueueGetsEachRevision) {
  Begin({}, {.queue = 4});
  TestWatcher watcher(*hub_, {});
  watcher.Drain();
  PublishPoints(1, 4);
  watcher.Drain();
  EXPECT_EQ(hub_->counts().behind, 0u);
  EXPECT_EQ(watcher.steps_, std::vector<std::uint64_t>(4, 1));
  EXPECT_EQ(hub_->counts().coalesced + hub_->counts().resynced, 0u);
  PublishPoints(5, 5);
  EXPECT_EQ(hub_->counts().behind, 1u);
}

TEST_F(WatchHubTest, AWatcherBehindTheHistoryGetsANewerSnapshot) {
  Begin({.revisions = 3}, {.queue = 2});
  TestWatcher watcher(*hub_, {});
  watcher.Drain();
  PublishPoints(1, 40);
  ASSERT_TRUE(store_->Latest().ok());
  PublishPoints(41, 42);
  watcher.Drain();
  EXPECT_EQ(watcher.snapshots_, 2);
  EXPECT_EQ(hub_->counts().resynced, 1u);
  EXPECT_EQ(watcher.replica_->revision(), 42u);
  EXPECT_EQ(watcher.replica_->hash(), store_->head().hash);
}

TEST_F(WatchHubTest, ALagThatOutweighsTheMeshIsAnsweredWithASnapshot) {
  Begin({}, {.queue = 4});
  PublishPoints(1, 3);
  TestWatcher watcher(*hub_, {});
  watcher.Drain();
  EXPECT_EQ(watcher.snapshots_, 1);
  for (int i = 0; i < 50; ++i) Publish({i % 2 == 0 ? AddPoint(9) : Edit::Remove(9)});
  ASSERT_TRUE(store_->Latest().ok());
  watcher.Drain();
  EXPECT_EQ(watcher.snapshots_, 2);
  EXPECT_EQ(watcher.replica_->hash(), store_->head().hash);
}

TEST_F(WatchHubTest, LateWatchersShareTheBaseAndCatchUp) {
  Begin({}, {.queue = 4});
  PublishPoints(1, 10);
  ASSERT_TRUE(store_->Latest().ok());
  PublishPoints(11, 30);
  const auto base = store_->base();
  TestWatcher watcher(*hub_, {});
  WatchItem item;
  ASSERT_EQ(watcher.subscription_->Next(&item), Subscription::Step::kWork);
  item = watcher.subscription_->Work();
  EXPECT_EQ(std::get<std::shared_ptr<const Mesh>>(item), base) << "a mesh was copied";
  watcher.Take(item);
  watcher.Drain();
  EXPECT_EQ(watcher.replica_->revision(), 30u);
  EXPECT_EQ(watcher.steps_.size(), 1u);
}

TEST_F(WatchHubTest, IdleWatchersGetProgressAtTheirInterval) {
  Begin({}, {.progress_interval = absl::Seconds(10)});
  TestWatcher often(*hub_, {.progress_interval = absl::Seconds(1)});
  TestWatcher seldom(*hub_, {});
  absl::Time now = absl::UnixEpoch();
  hub_->Tick(now);
  often.Drain();
  seldom.Drain();
  for (int second = 1; second <= 9; ++second) {
    hub_->Tick(now + absl::Seconds(second));
    often.WaitForWake();
    often.Drain();
    EXPECT_EQ(often.progress_, second);
  }
  EXPECT_EQ(seldom.untaken_wakes(), 0u);
  hub_->Tick(now + absl::Seconds(10));
  seldom.WaitForWake();
  seldom.Drain();
  EXPECT_EQ(seldom.progress_, 1);
}

TEST_F(WatchHubTest, ARevisionGoesBeforeProgressThatWasDue) {
  Begin();
  TestWatcher watcher(*hub_, {.progress_interval = absl::Seconds(1)});
  hub_->Tick(absl::UnixEpoch());
  watcher.Drain();
  hub_->Tick(absl::UnixEpoch() + absl::Seconds(5));
  watcher.WaitForWake();
  PublishPoints(1, 1);
  watcher.Drain();
  EXPECT_EQ(watcher.steps_.size(), 1u);
  EXPECT_EQ(watcher.progress_, 0);
}

TEST_F(WatchHubTest, CloseEndsIdleAndBusyWatchersAndRefusesNewOnes) {
  Begin();
  TestWatcher idle(*hub_, {}), busy(*hub_, {});
  idle.Drain();
  hub_->Close(absl::UnavailableError("draining"));
  idle.WaitForWake();
  idle.Drain(1);
  busy.Drain(1);
  EXPECT_EQ(idle.end_->code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(busy.end_->code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(hub_->Subscribe({}, [] {}).status().code(), absl::StatusCode::kUnavailable);
}

TEST_F(WatchHubTest, CancelSaysWhoEndsTheStream) {
  Begin();
  TestWatcher idle(*hub_, {}), busy(*hub_, {});
  idle.Drain();
  EXPECT_EQ(hub_->size(), 2u);
  EXPECT_TRUE(idle.subscription_->Cancel());
  EXPECT_FALSE(idle.subscription_->Cancel());
  EXPECT_FALSE(busy.subscription_->Cancel());
  busy.Drain(1);
  EXPECT_EQ(busy.end_->code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(hub_->size(), 0u);
  PublishPoints(1, 1);
  EXPECT_EQ(hub_->idle(), 0u);
}

// A writer and watchers at full speed: the thread that wakes a watcher drives it, as in the server.
// Lost wake-ups would hang; a replica detects lost or repeated revisions.
TEST_F(WatchHubTest, NothingIsLostWhileAWriterAndManyWatchersRace) {
  Begin({.revisions = 50}, {.queue = 8});
  constexpr FeatureId kRevisions = 400;
  constexpr int kWatchers = 20;
  std::vector<std::unique_ptr<TestWatcher>> watchers;
  for (int i = 0; i < kWatchers; ++i)
    watchers.push_back(std::make_unique<TestWatcher>(*hub_, WatchHub::Start{}));
  std::vector<std::thread> threads;
  for (int i = 0; i < kWatchers; ++i) {
    threads.emplace_back([w = watchers[static_cast<std::size_t>(i)].get()] {
      w->Drain();
      while (w->replica_->revision() < kRevisions) {
        w->WaitForWake();
        w->Drain();
      }
    });
  }
  for (FeatureId id = 1; id <= kRevisions; ++id) {
    PublishPoints(id, id);
    if (id % 37 == 0) {
      ASSERT_TRUE(store_->Latest().ok());
    }
  }
  for (std::thread& t : threads) t.join();
  for (const auto& w : watchers) EXPECT_EQ(w->replica_->hash(), store_->head().hash);
}

}  // namespace
}  // namespace dynmesh::server::watch_hub_test
