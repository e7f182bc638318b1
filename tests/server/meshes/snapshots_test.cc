// Snapshots for the journal beside the edits of their mesh: of what, when, and what ends them.
#include "server/journal/snapshots.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "proto/codec/journal_codec.h"
#include "server/base/memory_guard.h"
#include "tests/server/meshes/edit_group_fixture.h"
#include "tests/support/label_script.h"
#include "tests/support/polygon_script.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"
#include "tests/support/workload.h"

namespace dynmesh::server {
namespace {

class SnapshotsTest : public EditGroupTest {
 protected:
  SnapshotsTest() { options_.compact = {1, ~std::uint64_t{0}}; }
  ~SnapshotsTest() override { snapshots_->Stop(); }

  // A batch that is answered.
  void Put(MeshHost& host, EditBatch edits) {
    Hand(host, Job(std::move(edits)));
    const Result outcome = Next();
    ASSERT_TRUE(outcome.ok()) << outcome.status();
  }
  // What the strand has to do after the answers is done.
  void WaitForStrand(MeshHost& host) {
    Mailbox<int> idle;
    ASSERT_TRUE(host.Locate({}, nullptr, [&](const auto&) { idle.Put(0); }).ok());
    idle.Take();
  }
  // And the snapshots that it ordered are made.
  void Settle(MeshHost& host) {
    WaitForStrand(host);
    snapshots_->Wait();
  }
  // After the second of these a snapshot is due: the batch outweighs the first.
  void PutTwo(MeshHost& host) {
    Put(host, {AddPoint(1)});
    Put(host, ManyPoints(2, 3));
  }
  static std::vector<std::string> PartsOf(const std::vector<FeatureId>& points) {
    std::vector<Feature> features;
    for (const FeatureId id : points) features.push_back(AddPoint(id).feature);
    return codec::EncodeJournalSnapshot(features, HashOfFake(points), 2);
  }
};

TEST_F(SnapshotsTest, EditsGoOnWhileOneIsWritten) {
  const auto host = MakeHost();
  journal_.HoldSnapshots(true);
  PutTwo(*host);
  journal_.WaitForSnapshots(1);
  for (FeatureId id = 5; id <= 60; ++id) Put(*host, {AddPoint(id)});
  Put(*host, ManyPoints(61, 100));  // one that is written alone
  EXPECT_EQ(host->head().revision, 59u);
  EXPECT_EQ(journal_.snapshots(), 1);
  EXPECT_EQ(journal_.compacted(), 0u);
  WaitForStrand(*host);  // none is due while one is made
  journal_.HoldSnapshots(false);
  snapshots_->Wait();
  // Of the revision at which it was due. The batches behind it make the next one due.
  EXPECT_EQ(journal_.compacted(), 2u);
  EXPECT_EQ(journal_.parts(), PartsOf({1, 2, 3, 4}));
  Put(*host, {Edit::Remove(160)});
  Settle(*host);
  EXPECT_EQ(journal_.compacted(), 60u);
}

// What is written while one is made counts for the next one: that comes at the same revision.
TEST_F(SnapshotsTest, TheNextIsDueForAllThatCameAfterIt) {
  options_.compact = {500, ~std::uint64_t{0}};
  std::vector<std::uint64_t> expected;
  {
    const auto host = MakeHost();
    for (FeatureId id = 1; expected.size() < 2; ++id) {
      ASSERT_LT(id, 200u);
      const int before = journal_.snapshots();
      Put(*host, {AddPoint(id)});
      Settle(*host);
      if (journal_.snapshots() > before) expected.push_back(journal_.compacted());
    }
  }
  ScriptedJournal again;
  const auto snapshots = std::make_shared<Snapshots>(&again);
  MeshHost::Past past;
  past.log = std::make_unique<MeshLog>(&again, 1, "m", 2, MeshLog::Sizes(), options_.compact);
  options_.snapshots = snapshots;
  const auto host = MeshHost::Create("m", *MakeFake(MeshOptions(), gate_), absl::UnixEpoch(),
                                     &writers_, &readers_, options_, std::move(past));
  again.HoldSnapshots(true);
  FeatureId id = 1;
  while (id <= expected[0]) Put(*host, {AddPoint(id++)});
  again.WaitForSnapshots(1);
  while (id <= expected[0] + 3) Put(*host, {AddPoint(id++)});
  again.HoldSnapshots(false);
  snapshots->Wait();
  EXPECT_EQ(again.compacted(), expected[0]);
  while (again.snapshots() == 1 && id < 200) {
    Put(*host, {AddPoint(id++)});
    WaitForStrand(*host);
    snapshots->Wait();
  }
  EXPECT_EQ(again.compacted(), expected[1]);
  snapshots->Stop();
  WaitForStrand(*host);
}

TEST_F(SnapshotsTest, OneThatFailsIsMadeAgainWhenTwiceAsMuchWasWritten) {
  const auto host = MakeHost();
  journal_.AnswerSnapshots(DiskFull());
  PutTwo(*host);
  Settle(*host);
  EXPECT_EQ(journal_.snapshots(), 1);
  Put(*host, {AddPoint(5)});
  Settle(*host);
  EXPECT_EQ(journal_.snapshots(), 1);
  journal_.AnswerSnapshots(absl::OkStatus());
  Put(*host, ManyPoints(6, 5));
  Settle(*host);
  EXPECT_EQ(journal_.snapshots(), 2);
  EXPECT_EQ(journal_.compacted(), 4u);
}

// The mesh has what the journal has lost: the next snapshot is made of it, when all is written.
TEST_F(SnapshotsTest, AJournalThatCannotBeReadGetsTheMeshesFeatures) {
  const auto host = MakeHost();
  journal_.Damage(absl::DataLossError("a damaged row"));
  PutTwo(*host);
  Settle(*host);
  EXPECT_EQ(journal_.snapshots(), 0);
  std::vector<EditJob> jobs;
  for (FeatureId id = 5; id <= 9; ++id) jobs.push_back(Job({AddPoint(id)}));
  HandAll(*host, std::move(jobs));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(Next().ok());
  journal_.WaitForSnapshots(1);
  snapshots_->Wait();
  std::vector<FeatureId> points;
  for (FeatureId id = 1; id <= journal_.compacted() + 2; ++id) points.push_back(id);
  EXPECT_EQ(journal_.parts(), PartsOf(points));
  EXPECT_GE(journal_.compacted(), 3u);
}

TEST_F(SnapshotsTest, WaitWhileTheProcessIsAtItsMemoryLimit) {
  static std::atomic<std::uint64_t> resident;
  resident = 0;
  MemoryGuard guard(1'000, [] { return resident.load(); });
  options_.memory = &guard;
  const auto host = MakeHost();
  Put(*host, ManyPoints(1, 20));
  Put(*host, ManyPoints(21, 20));
  resident = 2'000;
  guard.Measure();
  // Removals are applied even so.
  for (FeatureId id = 1; id <= 40; ++id) Put(*host, {Edit::Remove(id)});
  Settle(*host);
  const int before = journal_.snapshots();
  EXPECT_LE(before, 1);
  resident = 0;
  guard.Measure();
  Put(*host, {AddPoint(50)});
  Settle(*host);
  EXPECT_EQ(journal_.snapshots(), before + 1);
  EXPECT_EQ(journal_.parts(), PartsOf({50}));
}

TEST_F(SnapshotsTest, TellHowLongEachPartTook) {
  std::vector<Snapshots::Made> observed;
  const auto observing = std::make_shared<Snapshots>(
      &journal_, [&](const Snapshots::Made& made) { observed.push_back(made); });
  const auto host = MakeHostOf(*MakeFake(MeshOptions(), gate_), observing);
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  PutTwo(*host);
  WaitForStrand(*host);
  observing->Wait();
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("off").ok());
  ASSERT_EQ(observed.size(), 1u);
  EXPECT_GT(observed[0].take, 0);
  EXPECT_GT(observed[0].encode, 0);
  EXPECT_GT(observed[0].write, 0);
  EXPECT_NE(log.find(absl::StrCat("event=compacted mesh=m revision=2")), std::string::npos) << log;
  EXPECT_NE(log.find(absl::StrCat("snapshot_bytes=", observed[0].bytes, " take_milliseconds=")),
            std::string::npos)
      << log;
  EXPECT_NE(log.find(" encode_milliseconds="), std::string::npos) << log;
  EXPECT_NE(log.find(" write_milliseconds="), std::string::npos) << log;
  observing->Stop();
}

TEST_F(SnapshotsTest, AMeshThatIsClosedEndsItsOwn) {
  const auto host = MakeHost();
  journal_.HoldSnapshots(true);
  PutTwo(*host);
  journal_.WaitForSnapshots(1);
  host->Close(absl::UnavailableError("closed"));
  snapshots_->Wait();
  EXPECT_EQ(journal_.compacted(), 0u);
}

TEST_F(SnapshotsTest, AHostThatIsLetGoEndsItsOwn) {
  auto host = MakeHost();
  journal_.HoldSnapshots(true);
  PutTwo(*host);
  journal_.WaitForSnapshots(1);
  WaitForStrand(*host);
  host.reset();
  snapshots_->Wait();
  EXPECT_EQ(journal_.compacted(), 0u);
}

TEST_F(SnapshotsTest, AreMadeOneAtATimeAndAllEndAtStop) {
  journal_.HoldSnapshots(true);
  ASSERT_TRUE(
      journal_.Append(1, {{1, ""}, {2, ""}, {3, ""}}, std::vector<Journal::Request>()).ok());
  std::atomic<int> ended{0}, made{0};
  const auto order_of = [&](std::uint64_t revision) {
    Snapshots::Order order;
    order.revision = revision;
    order.features = codec::FeaturesAt{revision, {}, {}};
    order.ended = std::make_shared<std::atomic<bool>>(false);
    order.done = [&](const Snapshots::Made& m) { ++(absl::IsCancelled(m.status) ? ended : made); };
    return order;
  };
  for (std::uint64_t r = 1; r <= 3; ++r) snapshots_->Make(order_of(r));
  journal_.WaitForSnapshots(1);
  snapshots_->Stop();
  EXPECT_EQ(ended, 3);
  EXPECT_EQ(journal_.snapshots(), 1);
  snapshots_->Make(order_of(4));
  EXPECT_EQ(ended, 4);
  EXPECT_EQ(made, 0);
}

// Of real meshes, to the byte that of the mesh's own features: all kinds, with labels.
class SnapshotBytes : public SnapshotsTest {
 protected:
  template <class Script>
  void Compare(Script script, int dimension, int steps) {
    SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed_));
    MeshOptions options;
    options.dimension = dimension;
    options.quality = DefaultQuality(dimension);
    MeshHost::Past past;
    options_.snapshots = snapshots_;
    past.log =
        std::make_unique<MeshLog>(&journal_, 1, "m", dimension, MeshLog::Sizes(), options_.compact);
    const auto host = MeshHost::Create("m", *DynamicMesh::Create(options), absl::UnixEpoch(),
                                       &writers_, &readers_, options_, std::move(past));
    const auto mirror = *DynamicMesh::Create(options);
    std::vector<std::vector<std::string>> expected = {{}};
    std::uint64_t last = 0;
    int compared = 0;
    for (int step = 0; step < steps; ++step) {
      const EditBatch batch = script.Next(mirror->Features());
      if (batch.empty() || !mirror->Apply(batch).ok()) continue;
      expected.push_back(
          codec::EncodeJournalSnapshot(mirror->Features(), mirror->hash(), dimension));
      Put(*host, batch);
      ASSERT_FALSE(HasFatalFailure());
      if (step % 3 != 0) continue;
      Settle(*host);
      if (journal_.compacted() == last) continue;
      last = journal_.compacted();
      ASSERT_EQ(journal_.parts(), expected[last]) << "step " << step;
      ++compared;
    }
    EXPECT_GE(compared, 2);
  }

  const std::uint64_t seed_ = test::NewSeed();
};

TEST_F(SnapshotBytes, AreThoseOfThePlanesFeatures) {
  Compare(test::LabelledScript(test::ScriptGenerator(test::Distribution::kPolygons, 40, seed_),
                               seed_ + 1),
          2, 60);
}

TEST_F(SnapshotBytes, AreThoseOfSizedFeatures) {
  Compare(
      test::LabelledScript(test::ScriptGenerator(test::Distribution::kSized, 40, seed_), seed_ + 1),
      2, 60);
}

TEST_F(SnapshotBytes, AreThoseOfSpacesFeatures) {
  Compare(
      test::LabelledScript(test::PolygonScript(test::PolygonKind::kMixture, 2, seed_), seed_ + 1),
      3, 30);
}

}  // namespace
}  // namespace dynmesh::server
