// Batches that are applied while others are being written: they are answered in order, once they
// are written themselves; no client sees one before; and a failed append undoes all that followed.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"
#include "server/base/mesh_name.h"
#include "tests/server/meshes/edit_group_fixture.h"
#include "tests/server/meshes/mesh_decorator.h"

namespace dynmesh::server {
namespace {

using absl::StatusCode;
using Sizes = std::vector<std::size_t>;

class EditPipelineTest : public EditGroupTest {
 protected:
  // With the batches r1 and r2 in flight, which add the points 1 and 2. The journal holds all
  // appends.
  std::shared_ptr<MeshHost> MakeHostInFlight() {
    const auto host = MakeHost();
    journal_.Hold();
    HandAll(*host, {PointJob(1), PointJob(2)});
    journal_.WaitForAppends(1);
    return host;
  }
  static EditJob PointJob(FeatureId id) { return Job({AddPoint(id)}, absl::StrCat("r", id)); }
  // The batches before it have added the points up to it. It is applied before the return.
  void HandBehind(MeshHost& host, FeatureId id) {
    Hand(host, PointJob(id));
    gate_->WaitForArrivals(static_cast<int>(id));
  }
  void ExpectNext(std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t revision = first; revision <= last; ++revision) {
      const Result result = Next();
      ASSERT_TRUE(result.ok()) << result.status();
      EXPECT_EQ(result->diff->to_revision, revision);
    }
  }
  void ExpectNextReason(const char* reason) { EXPECT_EQ(ReasonOf(Next().status()), reason); }
  static std::vector<FeatureId> UpTo(FeatureId last) {
    std::vector<FeatureId> points;
    for (FeatureId id = 1; id <= last; ++id) points.push_back(id);
    return points;
  }
};

TEST_F(EditPipelineTest, IsAppliedDuringAnAppendAndAnsweredAfterItsOwn) {
  const auto host = MakeHostInFlight();
  for (const FeatureId id : {3, 4, 5}) HandBehind(*host, id);
  ExpectHead(*host, 0, {});
  EXPECT_EQ(answers_.size(), 0u);
  journal_.ReleaseUpTo(1);
  ExpectNext(1, 2);
  journal_.WaitForAppends(2);
  HandBehind(*host, 6);
  ExpectHead(*host, 2, UpTo(2));
  EXPECT_EQ(answers_.size(), 0u);
  journal_.Release();
  ExpectNext(3, 6);
  ExpectHead(*host, 6, UpTo(6));
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 3, 1}));
}

TEST_F(EditPipelineTest, WatchersSeeARevisionWhenItIsWritten) {
  const auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  const auto woken = std::make_shared<Mailbox<int>>();
  const auto watch = *host->hub()->Subscribe({.revision = 0}, [woken] { woken->Put(0); });
  WatchItem item;
  ASSERT_EQ(watch->Next(&item), Subscription::Step::kIdle);
  std::uint64_t seen = 0;
  const auto see = [&](std::uint64_t revision) {
    while (seen < revision) {
      const Subscription::Step step = watch->Next(&item);
      if (step == Subscription::Step::kIdle) {
        woken->Take();
        continue;
      }
      if (step == Subscription::Step::kWork) item = watch->Work();
      seen = std::get<std::shared_ptr<const MeshDiff>>(item)->to_revision;
    }
    EXPECT_EQ(seen, revision);
    EXPECT_EQ(watch->Next(&item), Subscription::Step::kIdle);
  };
  journal_.ReleaseUpTo(1);
  see(2);
  journal_.WaitForAppends(2);
  EXPECT_EQ(host->head().revision, 2u);
  journal_.Release();
  see(3);
  ExpectNext(1, 3);
  watch->Cancel();
}

TEST_F(EditPipelineTest, ARetryOfWhatIsInFlightGetsItsAnswer) {
  const auto host = MakeHostInFlight();
  Hand(*host, PointJob(1));
  Hand(*host, Job({AddPoint(7)}, "r2"));
  HandBehind(*host, 3);
  Hand(*host, PointJob(3));
  journal_.ReleaseUpTo(1);
  const Result first = Next();
  ExpectNext(2, 2);
  const Result again = Next();
  ASSERT_TRUE(first.ok() && again.ok());
  EXPECT_TRUE(again->replayed && !first->replayed);
  EXPECT_EQ(again->diff, first->diff);
  ExpectNextReason(codec::reason::kRequestIdReused);
  journal_.WaitForAppends(2);
  EXPECT_EQ(answers_.size(), 0u);
  journal_.Release();
  ExpectNext(3, 3);
  EXPECT_TRUE(Next()->replayed);
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 1}));
}

TEST_F(EditPipelineTest, ARefusalWaitsForTheBatchesThatItDependsOn) {
  const auto host = MakeHostInFlight();
  Hand(*host, Job({AddPoint(1)}));
  HandBehind(*host, 3);
  Hand(*host, Job({AddPoint(3)}));
  EditJob late = Job({AddPoint(9)});
  late.expected_revision = 2;
  Hand(*host, std::move(late));
  journal_.ReleaseUpTo(1);
  ExpectNext(1, 2);
  ExpectNextReason(reason::kIdInUse);  // needs no append of its own
  journal_.WaitForAppends(2);
  EXPECT_EQ(answers_.size(), 0u);
  journal_.Answer([](int) { return DiskFull(); });
  journal_.Release();
  for (int i = 0; i < 3; ++i) ExpectJournalFailed(Next());
  ExpectHead(*host, 2, {1, 2});
}

TEST_F(EditPipelineTest, AFailureTakesBackWhatIsInFlightAndWhatFollows) {
  const auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  HandBehind(*host, 4);
  journal_.Answer([](int n) { return n == 1 ? DiskFull() : absl::OkStatus(); });
  journal_.Release();
  for (int i = 0; i < 4; ++i) ExpectJournalFailed(Next());
  ExpectHead(*host, 0, {});
  EXPECT_EQ(journal_.appends(), 1);
  HandAll(*host, {PointJob(1), PointJob(2), PointJob(3), PointJob(4)});
  ExpectNext(1, 4);
  ExpectHead(*host, 4, UpTo(4));
}

TEST_F(EditPipelineTest, AFailureLeavesWhatWasWrittenBefore) {
  const auto host = MakeHostInFlight();
  for (const FeatureId id : {3, 4}) HandBehind(*host, id);
  journal_.ReleaseUpTo(1);
  ExpectNext(1, 2);
  journal_.WaitForAppends(2);
  HandBehind(*host, 5);
  journal_.Answer([](int n) { return n == 2 ? DiskFull() : absl::OkStatus(); });
  journal_.Release();
  for (int i = 0; i < 3; ++i) ExpectJournalFailed(Next());
  ExpectHead(*host, 2, {1, 2});
  HandAll(*host, {PointJob(5), PointJob(4)});
  ExpectNext(3, 4);
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 2}));
}

TEST_F(EditPipelineTest, AFencedHostAnswersAllThatItHolds) {
  const auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  journal_.Answer([](int) { return absl::AbortedError("epoch 3 has the mesh"); });
  journal_.Release();
  for (int i = 0; i < 3; ++i) ExpectNextReason(codec::reason::kNotOwner);
  EXPECT_TRUE(host->disowned());
  ExpectHead(*host, 0, {});
  EXPECT_EQ(journal_.appends(), 1);
}

TEST_F(EditPipelineTest, OnlyWhatWasHandedToTheJournalHasAnUnknownOutcome) {
  const auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  Hand(*host, Job({AddPoint(3)}));
  journal_.Answer([](int) { return absl::UnknownError("the connection was lost"); });
  journal_.Release();
  for (int i = 0; i < 2; ++i) ExpectNextReason(codec::reason::kOutcomeUnknown);
  for (int i = 0; i < 2; ++i) ExpectNextReason(codec::reason::kNotOwner);
  EXPECT_EQ(journal_.appends(), 1);
}

TEST_F(EditPipelineTest, AHostThatStepsDownAppendsNoMore) {
  const auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  host->StepDown(absl::AbortedError("another server has the mesh"));
  Hand(*host, PointJob(4));
  journal_.Release();
  ExpectNext(1, 2);
  ExpectNextReason(codec::reason::kNotOwner);
  ExpectNextReason(codec::reason::kNotOwner);
  EXPECT_EQ(journal_.appends(), 1);
  ExpectHead(*host, 2, {1, 2});
}

TEST_F(EditPipelineTest, OfAMeshThatIsDeletedMeanwhileIsRefused) {
  const auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  journal_.Answer([](int) { return absl::NotFoundError("no such mesh"); });
  host->Close(MeshDeletedError("m"));
  Hand(*host, PointJob(4));
  journal_.Release();
  for (int i = 0; i < 4; ++i) ExpectNextReason(codec::reason::kMeshDeleted);
}

TEST_F(EditPipelineTest, AQueryWaitsForAllBeforeItAndTakesNoThread) {
  const auto host = MakeHostInFlight();  // one of two threads
  HandBehind(*host, 3);
  Mailbox<absl::StatusOr<MeshHost::LocateAnswer>> located;
  const auto locate = [&](const auto& flag) {
    ASSERT_TRUE(
        host->Locate({0.5, 0.5}, flag, [&](auto answer) { located.Put(std::move(answer)); }).ok());
  };
  const auto flag = std::make_shared<std::atomic<bool>>(false);
  locate(nullptr);
  locate(flag);
  Hand(*host, PointJob(4));
  Mailbox<int> beside;
  writers_.Post([&] { beside.Put(0); });
  beside.Take();
  flag->store(true);
  host->Withdraw(flag);
  EXPECT_EQ(located.Take().status().code(), StatusCode::kCancelled);
  journal_.ReleaseUpTo(1);
  ExpectNext(1, 2);
  journal_.WaitForAppends(2);
  EXPECT_EQ(located.size(), 0u);
  EXPECT_GE(host->waiting(), 1u);  // what is behind the query is not applied
  journal_.Release();
  EXPECT_EQ(located.Take()->revision, 3u);
  ExpectNext(3, 4);
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 1, 1}));
}

TEST_F(EditPipelineTest, ALargeBatchAndARevertComeAfterAllBeforeThem) {
  const auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  Hand(*host, Job(ManyPoints(100, 100)));
  EditJob made = Job({});
  made.make = [](const DynamicMesh& mesh) -> absl::StatusOr<EditBatch> {
    EXPECT_EQ(mesh.revision(), 5u);
    return EditBatch{AddPoint(5)};
  };
  Hand(*host, PointJob(4));
  Hand(*host, std::move(made));
  journal_.Release();
  ExpectNext(1, 6);
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 1, 1, 1, 1}));
}

TEST_F(EditPipelineTest, NoMoreIsAppliedThanMayBeHeld) {
  options_.held.edits = 4;
  const auto host = MakeHostInFlight();
  for (const FeatureId id : {3, 4}) HandBehind(*host, id);
  const auto flag = std::make_shared<std::atomic<bool>>(false);
  EditJob cancelled = Job({AddPoint(9)});
  cancelled.cancelled = flag;
  Mailbox<Result> gone;
  Hand(*host, PointJob(5));
  ASSERT_TRUE(Submit(*host, std::move(cancelled), gone).ok());
  Hand(*host, PointJob(6));
  flag->store(true);
  host->Withdraw(flag);
  EXPECT_EQ(gone.Take().status().code(), StatusCode::kCancelled);
  journal_.ReleaseUpTo(1);
  ExpectNext(1, 2);
  journal_.WaitForAppends(2);
  gate_->WaitForArrivals(6);
  EXPECT_EQ(answers_.size(), 0u);
  journal_.Release();
  ExpectNext(3, 6);
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 2, 2}));
  EXPECT_EQ(host->waiting(), 0u);
}

TEST_F(EditPipelineTest, AllIsAnsweredIfTheWritersStopAndTheHostIsLetGo) {
  auto host = MakeHostInFlight();
  HandBehind(*host, 3);
  Hand(*host, Job(ManyPoints(100, 100)));  // waits for the others
  host->Close(absl::UnavailableError("the server ends"));
  host.reset();
  std::thread stopping([&] { writers_.Stop(); });
  journal_.Release();
  stopping.join();
  EXPECT_EQ(answers_.size(), 4u);
  ExpectNext(1, 3);
  EXPECT_EQ(Next().status().message(), "the server ends");
}

TEST_F(EditPipelineTest, ASnapshotComesWhateverIsHeld) {
  options_.compact = {1, 1};
  options_.held.edits = 3;
  const auto host = MakeHost();
  std::vector<EditJob> jobs;
  for (FeatureId id = 1; id <= 100; ++id) jobs.push_back(PointJob(id));
  HandAll(*host, std::move(jobs));
  ExpectNext(1, 100);
  journal_.WaitForSnapshots(1);
}

TEST_F(EditPipelineTest, AStreamThatEndsAtTheFirstRefusedBatchEndsWithTheAppend) {
  const auto host = MakeHost();
  journal_.Hold();
  const auto stop = std::make_shared<std::atomic<bool>>(false);
  const auto job = [&](FeatureId id) {
    EditJob made = PointJob(id);
    made.stop = stop;
    return made;
  };
  HandAll(*host, {job(1), job(2)});
  journal_.WaitForAppends(1);
  Hand(*host, job(3));
  gate_->WaitForArrivals(3);
  journal_.Answer([](int) { return DiskFull(); });
  journal_.Release();
  for (int i = 0; i < 3; ++i) ExpectJournalFailed(Next());
  Hand(*host, job(4));
  EXPECT_EQ(Next().status().code(), StatusCode::kCancelled);
  ExpectHead(*host, 0, {});
}

// Takes long for each batch with more than one edit, and tells its progress meanwhile.
class LongMesh final : public MeshDecorator {
 public:
  // `runs` is set while one takes long, which it does until `go`.
  LongMesh(std::unique_ptr<DynamicMesh> mesh, const std::atomic<bool>* go, std::atomic<bool>* runs)
      : MeshDecorator(std::move(mesh)), go_(go), runs_(runs) {}
  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const ApplyOptions& options) override {
    const auto end = std::chrono::steady_clock::now() + test::kPatience;
    while (batch.size() > 1 && !*go_ && std::chrono::steady_clock::now() < end) {
      *runs_ = true;
      options.progress({ApplyProgress::Stage::kRefine, 1, 2});
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return mesh_->Apply(batch, options);
  }

 private:
  const std::atomic<bool>* const go_;
  std::atomic<bool>* const runs_;
};

class LongBatchTest : public EditPipelineTest {
 protected:
  LongBatchTest() { options_.long_batch = std::chrono::milliseconds(0); }
  ~LongBatchTest() override {
    go_ = true;
    journal_.Release();
    writers_.Stop();  // before go_ goes
  }
  std::shared_ptr<MeshHost> MakeLong() {
    return MakeHostOf(std::make_unique<LongMesh>(*MakeFake(MeshOptions(), gate_), &go_, &runs_));
  }
  static EditJob LongJob(FeatureId id) { return Job({AddPoint(id), AddPoint(id + 1)}); }

  std::atomic<bool> go_{false}, runs_{false};
};

TEST_F(LongBatchTest, DoesNotDelayTheBatchesBeforeIt) {
  const auto host = MakeLong();
  HandAll(*host, {PointJob(1), LongJob(2), Job({AddPoint(2)})});
  ExpectNext(1, 1);
  ExpectHead(*host, 1, {1});
  journal_.Answer([](int) { return DiskFull(); });
  go_ = true;
  ExpectJournalFailed(Next());
  ExpectJournalFailed(Next());
  ExpectHead(*host, 1, {1});
  journal_.Answer(nullptr);
  HandAll(*host, {LongJob(2), PointJob(4)});
  ExpectNext(2, 3);
  ExpectHead(*host, 3, {1, 2, 3, 4});
}

TEST_F(LongBatchTest, TakesNothingBackOfWhatWasPublishedMeanwhile) {
  const auto host = MakeLong();
  journal_.Hold();
  HandAll(*host, {PointJob(1), PointJob(2)});
  journal_.WaitForAppends(1);  // of the first: here any second batch is a long one
  HandBehind(*host, 3);
  Hand(*host, LongJob(4));
  test::WaitUntil("the long batch", [&] { return runs_.load(); });
  journal_.ReleaseUpTo(1);
  ExpectNext(1, 1);  // while that one runs
  journal_.WaitForAppends(2);
  ExpectHead(*host, 1, {1});
  journal_.Answer([](int n) { return n == 2 ? DiskFull() : absl::OkStatus(); });
  journal_.Release();
  go_ = true;
  for (int i = 0; i < 3; ++i) ExpectJournalFailed(Next());
  ExpectHead(*host, 1, {1});
  HandAll(*host, {PointJob(3), LongJob(4)});
  ExpectNext(2, 3);
  ExpectHead(*host, 3, {1, 3, 4, 5});
}

}  // namespace
}  // namespace dynmesh::server
