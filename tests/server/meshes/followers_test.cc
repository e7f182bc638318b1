// Meshes that another node has, made again from the journal: what is read of them, what ends them,
// and how they are taken over. Registries of several nodes share a database in memory.
#include "server/meshes/followers.h"

#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "proto/codec/journal_codec.h"
#include "server/base/log.h"
#include "server/cluster/placement.h"
#include "server/meshes/hand_over.h"
#include "server/meshes/mesh_registry.h"
#include "tests/server/meshes/memory_cluster.h"
#include "tests/server/test_support.h"

namespace dynmesh::server::followers_test {
namespace {

using HostPtr = MeshRegistry::HostPtr;
using Opened = absl::StatusOr<HostPtr>;
using Mesh = MemoryCluster::Mesh;

// A node: a journal and a registry.
struct TestNode {
  TestNode(MemoryCluster* cluster, const std::string& address, const ServerConfig& config,
           WorkerPool* writers, WorkerPool* readers, const MeshFactory& factory)
      : journal(cluster, address), registry(config, factory, writers, readers, &journal, &metrics) {
    EXPECT_TRUE(registry.Join(address, [] { return true; }).ok());
  }
  MemoryCluster::Node journal;
  ServerMetrics metrics;
  MeshRegistry registry;
};

class FollowersTest : public ::testing::Test {
 protected:
  FollowersTest() {
    EXPECT_TRUE(SetLogLevel("off").ok());
    config_.followers = 0;  // on demand only
  }
  ~FollowersTest() override { gate_->Release(); }

  TestNode& AddNode(const std::string& address) {
    nodes_.push_back(
        std::make_unique<TestNode>(&cluster_, address, config_, &writers_, &readers_,
                                   [gate = gate_](const MeshOptions& options, const ApplyOptions&) {
                                     return MakeFake(options, gate);
                                   }));
    return *nodes_.back();
  }
  // The mesh m of the first node, and another node.
  void MakeTwo() {
    AddNode("a:1");
    AddNode("b:1");
    ASSERT_TRUE(A().registry.Create("m", MeshOptions(), "make").ok());
  }
  TestNode& A() { return *nodes_[0]; }
  TestNode& B() { return *nodes_[1]; }

  static absl::StatusOr<EditOutcome> Apply(MeshHost& host, EditBatch edits,
                                           const std::string& request_id = "") {
    Mailbox<absl::StatusOr<EditOutcome>> answer;
    EditJob job;
    job.edits = std::move(edits);
    job.request_id = request_id;
    job.done = [&answer](absl::StatusOr<EditOutcome> outcome) { answer.Put(std::move(outcome)); };
    EXPECT_TRUE(host.Apply(std::move(job)).ok());
    return answer.Take();
  }
  HostPtr HostOf(TestNode& node) {
    const Opened host = node.registry.Find("meshes/m");
    EXPECT_TRUE(host.ok()) << host.status();
    return *host;
  }
  // Points `from` to `to`, each in a batch with the request id of its number.
  void Grow(TestNode& node, FeatureId from, FeatureId to) {
    for (FeatureId id = from; id <= to; ++id) {
      const auto applied = Apply(*HostOf(node), {AddPoint(id)}, absl::StrCat("r", id));
      ASSERT_TRUE(applied.ok()) << applied.status();
    }
  }
  static Opened Read(TestNode& node, std::uint64_t min_revision, const std::string& id = "m") {
    Mailbox<Opened> answer;
    node.registry.OpenToRead("meshes/" + id, {}, min_revision,
                             [&answer](const Opened& host) { answer.Put(host); });
    return answer.Take();
  }
  static std::string OwnerIn(const absl::Status& status) {
    const auto error = codec::GetServiceError(status);
    if (!error.has_value() || error->reason != codec::reason::kNotOwner) return status.ToString();
    const auto owner = error->metadata.find("owner");
    return owner == error->metadata.end() ? "no address" : owner->second;
  }
  static std::size_t Follows(TestNode& node) { return node.registry.Followed().size(); }
  static double Mismatches(TestNode& node) {
    return static_cast<double>(node.metrics.followers.mismatches.value());
  }
  // Of the entry of the last revision.
  void FalsifyTheLast(const MeshHash& hash) {
    cluster_.With("m", [&hash](Mesh& mesh) {
      Journal::Entry& last = mesh.entries.back();
      const auto entry = codec::DecodeJournalEntry(last.data, 2);
      last.data = codec::EncodeJournalEntry(entry->edits, hash, 2);
    });
  }
  // Appends that batch as its owner would, but with that hash.
  void AppendFalse(TestNode& node, std::uint64_t revision, const EditBatch& edits,
                   const MeshHash& hash) {
    const Journal::Entry entry{revision, codec::EncodeJournalEntry(edits, hash, 2)};
    ASSERT_TRUE(node.journal.Append(1, entry, std::nullopt).ok());
  }

  MemoryCluster cluster_;
  ServerConfig config_;
  std::shared_ptr<FakeGate> gate_ = std::make_shared<FakeGate>();
  WorkerPool writers_{4}, readers_{2};
  std::deque<std::unique_ptr<TestNode>> nodes_;
};

TEST_F(FollowersTest, AReadThatMayBeOldIsAnsweredByAnyNode) {
  MakeTwo();
  Grow(A(), 1, 3);
  const Opened opened = Read(B(), 3);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_EQ((*opened)->head().revision, 3u);
  EXPECT_EQ((*opened)->head().hash, HostOf(A())->head().hash);
  EXPECT_EQ((*opened)->stats().features, 3u);
  EXPECT_TRUE((*opened)->follows());
  // It goes on.
  Grow(A(), 4, 40);
  const Opened again = Read(B(), 40);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(*again, *opened);
  EXPECT_EQ((*again)->head().hash, HostOf(A())->head().hash);
  EXPECT_EQ(B().journal.reads(), 1);
  EXPECT_EQ(cluster_.OwnerOf("m"), "a:1");
  // A read of the present state, and edits, are the owner's.
  Mailbox<Opened> answer;
  B().registry.Open("meshes/m", {}, [&answer](const Opened& host) { answer.Put(host); });
  EXPECT_EQ(OwnerIn(answer.Take().status()), "a:1");
  EXPECT_EQ(ReasonOf(Apply(**opened, {AddPoint(50)}).status()), codec::reason::kNotOwner);
}

TEST_F(FollowersTest, AFollowersPlacesAreTheOwners) {
  MakeTwo();
  Grow(A(), 1, 5);
  const auto locate = [](MeshHost& host) {
    Mailbox<absl::StatusOr<MeshHost::LocateAnswer>> answer;
    EXPECT_TRUE(
        host.Locate({0.5, 0.5}, nullptr, [&answer](auto found) { answer.Put(std::move(found)); })
            .ok());
    return answer.Take();
  };
  const Opened followed = Read(B(), 5);
  ASSERT_TRUE(followed.ok()) << followed.status();
  const auto here = locate(**followed), there = locate(*HostOf(A()));
  ASSERT_TRUE(here.ok()) << here.status();
  EXPECT_EQ(here->revision, 5u);
  EXPECT_EQ(here->simplices, there->simplices);
  EXPECT_EQ((*(*followed)->store()->Latest())->hash, (*HostOf(A())->store()->Latest())->hash);
}

TEST_F(FollowersTest, ARevisionThatDoesNotComeIsTheOwnersToTell) {
  MakeTwo();
  Grow(A(), 1, 1);
  EXPECT_EQ(OwnerIn(Read(B(), 2).status()), "a:1");
  EXPECT_EQ(ReasonOf(Read(A(), 2).status()), codec::reason::kFutureRevision);
  EXPECT_EQ(ReasonOf(Read(B(), 0, "x").status()), codec::reason::kMeshNotFound);
}

TEST_F(FollowersTest, AFreeMeshIsOpenedByItsReader) {
  MakeTwo();
  Grow(A(), 1, 2);
  cluster_.Free("m");
  const Opened opened = Read(B(), 2);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_FALSE((*opened)->follows());
  EXPECT_EQ(cluster_.OwnerOf("m"), "b:1");
}

TEST_F(FollowersTest, WatchesGetWhatTheJournalGets) {
  MakeTwo();
  Grow(A(), 1, 2);
  const HostPtr host = *Read(B(), 2);
  Mailbox<int> woken;
  WatchHub::Start start;
  start.revision = 2;
  const auto watch = host->hub()->Subscribe(start, [&woken] { woken.Put(0); });
  ASSERT_TRUE(watch.ok()) << watch.status();
  WatchItem item;
  std::uint64_t revision = 2;
  const auto take = [&] {
    while (true) {
      switch ((*watch)->Next(&item)) {
        case Subscription::Step::kItem:
          return;
        case Subscription::Step::kIdle:
          woken.Take();
          break;
        case Subscription::Step::kWork:
          FAIL() << "a snapshot or a joined diff";
      }
    }
  };
  Grow(A(), 3, 12);
  while (revision < 12) {
    take();
    const auto* const diff = std::get_if<std::shared_ptr<const MeshDiff>>(&item);
    ASSERT_NE(diff, nullptr);
    EXPECT_EQ((*diff)->from_revision, revision);
    revision = (*diff)->to_revision;
  }
  EXPECT_EQ(host->head().hash, HostOf(A())->head().hash);
  // A deleted mesh ends them.
  ASSERT_TRUE(A().registry.Delete("meshes/m").ok());
  take();
  const auto* const ended = std::get_if<absl::Status>(&item);
  ASSERT_NE(ended, nullptr);
  EXPECT_EQ(ReasonOf(*ended), codec::reason::kMeshDeleted);
  EXPECT_EQ(Follows(B()), 0u);
  (*watch)->Cancel();
}

TEST_F(FollowersTest, AFalseHashEndsTheReplicaAndIsTold) {
  MakeTwo();
  Grow(A(), 1, 3);
  ASSERT_TRUE(Read(B(), 3).ok());
  const HostPtr host = *Read(B(), 3);
  AppendFalse(A(), 4, {AddPoint(4)}, HashOfFake({1, 2, 3}));
  test::WaitUntil("the end of the replica", [&] { return Follows(B()) == 0; });
  EXPECT_EQ(Mismatches(B()), 1);
  EXPECT_EQ(host->head().revision, 3u) << "readers see the last good revision";
  // It is read again, once: the journal is false.
  EXPECT_EQ(OwnerIn(Read(B(), 0).status()), "a:1");
  EXPECT_EQ(Mismatches(B()), 2);
  const int reads = B().journal.reads();
  EXPECT_EQ(OwnerIn(Read(B(), 0).status()), "a:1");
  EXPECT_EQ(Mismatches(B()), 2);
  EXPECT_EQ(B().journal.reads(), reads);
}

TEST_F(FollowersTest, AReplicaThatWasWrongIsReadAgainAndGoesOn) {
  MakeTwo();
  Grow(A(), 1, 3);
  ASSERT_TRUE(Read(B(), 3).ok());
  MeshHash right = HashOfFake({1, 2, 3, 4});
  AppendFalse(A(), 4, {AddPoint(4)}, HashOfFake({1}));
  test::WaitUntil("the end of the replica", [&] { return Follows(B()) == 0; });
  FalsifyTheLast(right);
  const Opened again = Read(B(), 4);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ((*again)->head().hash, right);
  EXPECT_EQ(Mismatches(B()), 1);
}

TEST_F(FollowersTest, EntriesOfOtherBitsAreNotFollowedAndAreNoMismatch) {
  MakeTwo();
  Grow(A(), 1, 2);
  ASSERT_TRUE(Read(B(), 2).ok());
  const Journal::Entry entry{
      3, codec::EncodeJournalEntry({AddPoint(3)}, HashOfFake({1, 2, 3}), 2, kMeshBits + 1)};
  ASSERT_TRUE(A().journal.Append(1, entry, std::nullopt).ok());
  test::WaitUntil("the end of the replica", [&] { return Follows(B()) == 0; });
  EXPECT_EQ(OwnerIn(Read(B(), 0).status()), "a:1");
  EXPECT_EQ(Mismatches(B()), 0);
}

TEST_F(FollowersTest, AFollowerThatTheJournalLeftBehindReadsTheMeshAgain) {
  MakeTwo();
  Grow(A(), 1, 3);
  const HostPtr first = *Read(B(), 3);
  cluster_.Fail(true);
  Grow(A(), 4, 6);
  cluster_.With("m", [](Mesh& mesh) {
    std::vector<Feature> features;
    for (FeatureId id = 1; id <= 5; ++id) features.push_back(AddPoint(id).feature);
    mesh.snapshot = 5;
    mesh.parts = codec::EncodeJournalSnapshot(features, HashOfFake({1, 2, 3, 4, 5}), 2);
    mesh.entries.erase(mesh.entries.begin(), mesh.entries.begin() + 5);
  });
  cluster_.Fail(false);
  test::WaitUntil("the end of the replica", [&] { return Follows(B()) == 0; });
  const Opened again = Read(B(), 6);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_NE(*again, first);
  EXPECT_EQ((*again)->head().hash, HostOf(A())->head().hash);
  EXPECT_EQ(Mismatches(B()), 0);
}

TEST_F(FollowersTest, AFreedMeshIsTakenOverWithoutReadingIt) {
  MakeTwo();
  Grow(A(), 1, 20);
  const HostPtr host = *Read(B(), 20);
  Mailbox<int> woken;
  WatchHub::Start start;
  start.revision = 20;
  const auto watch = host->hub()->Subscribe(start, [&woken] { woken.Put(0); });
  cluster_.Free("m");
  test::WaitUntil("the take-over", [&] { return B().registry.Find("meshes/m").ok(); });
  EXPECT_EQ(HostOf(B()), host);
  EXPECT_FALSE(host->follows());
  EXPECT_EQ(B().journal.reads(), 1);
  EXPECT_EQ(Follows(B()), 0u);
  EXPECT_EQ(B().metrics.followers.takeovers.value(), 1u);
  Grow(B(), 21, 25);
  EXPECT_EQ(host->head().hash, HashOfFake([] {
              std::vector<FeatureId> ids;
              for (FeatureId id = 1; id <= 25; ++id) ids.push_back(id);
              return ids;
            }()));
  // Retries of what the first owner was asked are recognised, and watches go on.
  const auto retried = Apply(*host, {AddPoint(7)}, "r7");
  ASSERT_TRUE(retried.ok()) << retried.status();
  EXPECT_TRUE(retried->replayed);
  EXPECT_EQ(retried->diff->to_revision, 7u);
  WatchItem item;
  ASSERT_EQ((*watch)->Next(&item), Subscription::Step::kItem);
  EXPECT_EQ(std::get<std::shared_ptr<const MeshDiff>>(item)->to_revision, 21u);
  (*watch)->Cancel();
  // The first owner is fenced.
  EXPECT_EQ(ReasonOf(Apply(*HostOf(A()), {AddPoint(99)}).status()), codec::reason::kNotOwner);
}

TEST_F(FollowersTest, ATakeOverAppliesWhatIsMissing) {
  MakeTwo();
  Grow(A(), 1, 5);
  const HostPtr host = *Read(B(), 5);
  cluster_.Fail(true);
  Grow(A(), 6, 9);
  cluster_.Free("m");
  cluster_.Fail(false);
  test::WaitUntil("the take-over", [&] { return B().registry.Find("meshes/m").ok(); });
  EXPECT_EQ(HostOf(B()), host);
  EXPECT_EQ(host->head().revision, 9u);
  Grow(B(), 10, 10);
  const auto retried = Apply(*host, {AddPoint(9)}, "r9");
  ASSERT_TRUE(retried.ok()) << retried.status();
  EXPECT_TRUE(retried->replayed);
}

TEST_F(FollowersTest, AMeshThatAnotherNodeClaimedFirstIsFollowedOn) {
  MakeTwo();
  AddNode("c:1");
  Grow(A(), 1, 3);
  const HostPtr b = *Read(B(), 3), c = *Read(*nodes_[2], 3);
  cluster_.Free("m");
  test::WaitUntil("a take-over", [&] { return cluster_.OwnerOf("m") != ""; });
  const std::string owner = cluster_.OwnerOf("m");
  TestNode& next = owner == "b:1" ? B() : *nodes_[2];
  TestNode& other = owner == "b:1" ? *nodes_[2] : B();
  test::WaitUntil("the mesh", [&] { return next.registry.Find("meshes/m").ok(); });
  Grow(next, 4, 8);
  const Opened followed = Read(other, 8);
  ASSERT_TRUE(followed.ok()) << followed.status();
  EXPECT_EQ(*followed, owner == "b:1" ? c : b);
  EXPECT_TRUE((*followed)->follows());
}

TEST_F(FollowersTest, NoMoreMeshesAreFollowedThanMayBe) {
  config_.max_followed_meshes = 1;
  MakeTwo();
  ASSERT_TRUE(A().registry.Create("n", MeshOptions(), "").ok());
  ASSERT_TRUE(Read(B(), 0).ok());
  EXPECT_EQ(OwnerIn(Read(B(), 0, "n").status()), "a:1");
  EXPECT_EQ(Follows(B()), 1u);
}

// ------------------------------------------------------------------ placement and hand-over

class WarmTest : public FollowersTest {
 protected:
  WarmTest() { config_.followers = 1; }

  // The mesh m of node a, which of the others b and c one follows. Returns that one.
  TestNode& MakeThree() {
    for (const char* address : {"a:1", "b:1", "c:1"}) AddNode(address);
    EXPECT_TRUE(A().registry.Create("m", MeshOptions(), "make").ok());
    Grow(A(), 1, 1);
    test::WaitUntil("a follower", [&] { return Follows(B()) + Follows(*nodes_[2]) > 0; });
    grown_ = 1;
    const bool is_b = NextNodes({"a:1", "b:1", "c:1"}, "a:1", "m", 1).front() == "b:1";
    EXPECT_EQ(Follows(B()), is_b ? 1u : 0u);
    EXPECT_EQ(Follows(*nodes_[2]), is_b ? 0u : 1u);
    return is_b ? B() : *nodes_[2];
  }
  // The meshes of node a, by key.
  std::vector<OwnedHost> OwnedByA() {
    std::vector<OwnedHost> owned;
    for (const auto& listed : A().registry.List("", 100)) {
      if (listed.host != nullptr)
        owned.push_back({listed.host, A().journal.Locate(listed.id)->mesh.key});
    }
    return owned;
  }
  FeatureId grown_ = 0;
};

TEST_F(WarmTest, AMeshInUseIsFollowedByTheNextNode) {
  TestNode& next = MakeThree();
  const Opened opened = Read(next, grown_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_EQ((*opened)->head().hash, HostOf(A())->head().hash);
}

TEST_F(WarmTest, ADrainHandsMeshesOverToTheirFollowers) {
  TestNode& next = MakeThree();
  const HostPtr follower = *Read(next, grown_);
  const int reads = next.journal.reads();
  const HostPtr old = HostOf(A());
  A().registry.HandOver(absl::Minutes(1));
  test::WaitUntil("the take-over", [&] { return next.registry.Find("meshes/m").ok(); });
  EXPECT_EQ(HostOf(next), follower);
  EXPECT_EQ(next.journal.reads(), reads);
  Grow(next, grown_ + 1, grown_ + 3);
  // What still comes to the old owner is sent on.
  const absl::Status late = Apply(*old, {AddPoint(999)}).status();
  EXPECT_EQ(OwnerIn(late), &next == &B() ? "b:1" : "c:1");
  Mailbox<Opened> answer;
  A().registry.Open("meshes/m", {}, [&answer](const Opened& host) { answer.Put(host); });
  EXPECT_EQ(OwnerIn(answer.Take().status()), &next == &B() ? "b:1" : "c:1");
}

TEST_F(WarmTest, AMeshIsHandedOverWhenTheFormerHasBeenClaimed) {
  MakeThree();
  for (const char* id : {"m2", "m3", "m4", "m5", "m6"}) {
    const Opened made = A().registry.Create(id, MeshOptions(), id);
    ASSERT_TRUE(made.ok() && Apply(**made, {AddPoint(1)}).ok());
  }
  test::WaitUntil("followers", [&] { return Follows(B()) + Follows(*nodes_[2]) == 6; });
  // It is claimed when the other nodes ask the journal next.
  HandMeshesOver(&A().journal, "a:1", OwnedByA(), absl::Minutes(1), absl::Minutes(1));
  EXPECT_EQ(cluster_.most_handed(), 1);
  for (const char* id : {"m", "m2", "m3", "m4", "m5", "m6"}) EXPECT_NE(cluster_.OwnerOf(id), "a:1");
}

TEST_F(WarmTest, AMeshThatIsNotClaimedDoesNotKeepTheNextBack) {
  AddNode("a:1");
  for (const char* id : {"m", "m2", "m3"}) {
    ASSERT_TRUE(A().registry.Create(id, MeshOptions(), id).ok());
  }
  MemoryCluster::Node idle(&cluster_, "b:1");  // never asks
  HandMeshesOver(&A().journal, "a:1", OwnedByA(), absl::Minutes(1), absl::Milliseconds(1));
  for (const char* id : {"m", "m2", "m3"}) EXPECT_EQ(cluster_.OwnerOf(id), "b:1");
  EXPECT_EQ(cluster_.most_handed(), 3);
}

TEST_F(WarmTest, WhatWaitsBehindAHandOverIsSentToTheNextOwner) {
  TestNode& next = MakeThree();
  gate_->Hold();
  const HostPtr old = HostOf(A());
  Mailbox<absl::StatusOr<EditOutcome>> answers;
  const auto hand = [&](FeatureId id) {
    EditJob job;
    job.edits = {AddPoint(id)};
    job.done = [&answers](absl::StatusOr<EditOutcome> outcome) { answers.Put(std::move(outcome)); };
    ASSERT_TRUE(old->Apply(std::move(job)).ok());
  };
  hand(grown_ + 1);
  Mailbox<absl::Status> given;
  old->HandOver(
      [&]() -> absl::StatusOr<MeshOwner> {
        const auto epoch = A().journal.HandOver(1, "c:1");
        return MeshOwner{"c:1", epoch.value_or(0)};
      },
      [&given](const absl::Status& status) { given.Put(status); });
  hand(grown_ + 2);
  gate_->Release();
  const auto first = answers.Take();
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(given.Take(), absl::OkStatus());
  EXPECT_EQ(OwnerIn(answers.Take().status()), "c:1");
  (void)next;
}

TEST_F(WarmTest, AMeshThatIsNotUsedIsNotFollowedAnyMore) {
  config_.follower_idle = absl::ZeroDuration();
  for (const char* address : {"a:1", "b:1"}) AddNode(address);
  ASSERT_TRUE(A().registry.Create("m", MeshOptions(), "make").ok());
  ASSERT_TRUE(Read(B(), 0).ok());
  test::WaitUntil("the end", [&] { return Follows(B()) == 0; });
  ASSERT_TRUE(Read(B(), 0).ok()) << "until it is asked for";
}

}  // namespace
}  // namespace dynmesh::server::followers_test
