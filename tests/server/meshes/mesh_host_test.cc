// The single writer: order, idempotence, preconditions, refusals, cancellation.
#include "server/meshes/mesh_host.h"

#include <gtest/gtest.h>

#include <limits>

#include "dynmesh/error.h"
#include "server/base/log.h"
#include "tests/server/meshes/mesh_decorator.h"
#include "tests/server/test_support.h"

namespace dynmesh::server::mesh_host_test {
namespace {

using MeshHostTest = HostFixture;

TEST_F(MeshHostTest, EachBatchMakesTheNextRevision) {
  const auto host = MakeHost();
  EXPECT_EQ(host->head().revision, 0u);
  for (FeatureId id = 1; id <= 5; ++id) {
    const Result result = Apply(*host, {AddPoint(id)});
    ASSERT_TRUE(result.ok()) << Text(result.status());
    EXPECT_EQ(result->diff->from_revision, id - 1);
    EXPECT_EQ(result->diff->to_revision, id);
    EXPECT_EQ(host->head().revision, id);
    EXPECT_EQ(host->head().hash, result->diff->hash);
    EXPECT_EQ(host->stats().features, id);
  }
}

TEST_F(MeshHostTest, BatchesAreAppliedInTheOrderHandedIn) {
  const auto host = MakeHost();
  gate_->Hold();
  Mailbox<Result> box;
  constexpr FeatureId kCount = 100;
  for (FeatureId id = 1; id <= kCount; ++id) {
    EditJob job;
    job.edits = {AddPoint(id)};
    ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  }
  gate_->Release();
  for (FeatureId id = 1; id <= kCount; ++id) {
    const Result result = box.Take();
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result->diff->to_revision, id);
    ASSERT_EQ(result->diff->added_vertices.size(), 1u);
    EXPECT_EQ(result->diff->added_vertices.owners[0], id);
  }
}

TEST_F(MeshHostTest, WhatIsWithdrawnIsAnsweredAtOnceAndWhatRunsGoesOn) {
  MeshHost::Options options;
  options.max_waiting = 3;
  const auto host = MakeHost(options);
  gate_->Hold();
  Mailbox<Result> first, withdrawn, last;
  Mailbox<absl::Status> located;
  const auto flag = std::make_shared<std::atomic<bool>>(false);
  const auto job = [](FeatureId id, std::shared_ptr<const std::atomic<bool>> cancelled) {
    EditJob made;
    made.edits = {AddPoint(id)};
    made.cancelled = std::move(cancelled);
    return made;
  };
  ASSERT_TRUE(Submit(*host, job(1, nullptr), first).ok());
  gate_->WaitForArrivals(1);
  ASSERT_TRUE(Submit(*host, job(2, flag), withdrawn).ok());
  ASSERT_TRUE(Submit(*host, job(3, flag), withdrawn).ok());
  ASSERT_TRUE(host->Locate({}, flag, [&](const auto& a) { located.Put(a.status()); }).ok());
  EXPECT_EQ(ReasonOf(Submit(*host, job(4, nullptr), last)), codec::reason::kQueueFull);
  flag->store(true);
  host->Withdraw(flag);
  EXPECT_EQ(withdrawn.Take().status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(withdrawn.Take().status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(located.Take().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(host->waiting(), 0u);
  EXPECT_EQ(first.size(), 0u);
  ASSERT_TRUE(Submit(*host, job(4, nullptr), last).ok());
  gate_->Release();
  EXPECT_TRUE(first.Take().ok());
  EXPECT_EQ(last.Take()->diff->to_revision, 2u);
}

TEST_F(MeshHostTest, AnEmptyBatchMakesNoRevision) {
  const auto host = MakeHost();
  const Result result = Apply(*host, EditBatch{});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->diff->from_revision, result->diff->to_revision);
  EXPECT_EQ(host->head().revision, 0u);
}

TEST_F(MeshHostTest, ARefusedBatchLeavesRevisionHashAndStats) {
  const auto host = MakeHost();
  ASSERT_TRUE(Apply(*host, {AddPoint(1)}).ok());
  const Head before = host->head();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const EditBatch bad_batches[] = {
      {AddPoint(2), Edit::Add(Feature::Point(3, nan, 0))},
      {AddPoint(2), Edit::Add(Feature::Point(3, inf, 0))},
      {AddPoint(2), Edit::Add(Feature::Point(3, 5, 5))},
      {AddPoint(2), AddPoint(1)},
      {AddPoint(2), Edit::Remove(77)},
      {AddPoint(2), Edit::Add(Feature::Segment(9, 1, 88))},
      {Edit::Add(Feature::Point(0, 0.5, 0.5))},
  };
  for (const EditBatch& batch : bad_batches) {
    const Result result = Apply(*host, batch);
    ASSERT_FALSE(result.ok());
    EXPECT_NE(ReasonOf(result.status()), "") << Text(result.status());
    EXPECT_EQ(host->head().revision, before.revision);
    EXPECT_EQ(host->head().hash, before.hash);
    EXPECT_EQ(host->stats().features, 1u);
  }
  // Nothing of a refused batch stuck: id 2 is still free.
  EXPECT_TRUE(Apply(*host, {AddPoint(2)}).ok());
}

TEST_F(MeshHostTest, TheOutcomeOfExpectedRevisionDependsOnTheRevisionAtItsTurn) {
  const auto host = MakeHost();
  EditJob job;
  job.edits = {AddPoint(1)};
  job.expected_revision = 0;
  ASSERT_TRUE(Apply(*host, job).ok());
  job.edits = {AddPoint(2)};
  const Result stale = Apply(*host, job);
  EXPECT_EQ(stale.status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(ReasonOf(stale.status()), codec::reason::kRevisionMismatch);
  EXPECT_EQ(codec::GetServiceError(stale.status())->metadata["revision"], "1");
  EXPECT_EQ(host->head().revision, 1u);
  job.expected_revision = 1;
  EXPECT_TRUE(Apply(*host, job).ok());
}

TEST_F(MeshHostTest, ARetryIsAnsweredWithTheFirstRevision) {
  const auto host = MakeHost();
  EditJob job;
  job.edits = {AddPoint(1)};
  job.request_id = "r1";
  job.expected_revision = 0;
  const Result first = Apply(*host, job);
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE(Apply(*host, {AddPoint(2)}).ok());
  // The expected revision has passed, the retry is answered all the same.
  const Result again = Apply(*host, job);
  ASSERT_TRUE(again.ok()) << Text(again.status());
  EXPECT_TRUE(again->replayed);
  EXPECT_FALSE(again->columns_omitted);
  EXPECT_EQ(again->diff->to_revision, 1u);
  EXPECT_EQ(again->diff->hash, first->diff->hash);
  EXPECT_EQ(again->diff->added_vertices, first->diff->added_vertices);
  EXPECT_EQ(host->head().revision, 2u);
}

TEST_F(MeshHostTest, ARetryWithOtherEditsIsRefused) {
  const auto host = MakeHost();
  ASSERT_TRUE(Apply(*host, {AddPoint(1)}, "r1").ok());
  const Result other = Apply(*host, {AddPoint(2)}, "r1");
  EXPECT_EQ(other.status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(ReasonOf(other.status()), codec::reason::kRequestIdReused);
  EXPECT_EQ(host->head().revision, 1u);
}

TEST_F(MeshHostTest, ARefusedBatchMayBeTriedAgainUnderTheSameRequestId) {
  const auto host = MakeHost();
  ASSERT_FALSE(Apply(*host, {Edit::Remove(1)}, "r1").ok());
  ASSERT_TRUE(Apply(*host, {AddPoint(1)}).ok());
  const Result second = Apply(*host, {Edit::Remove(1)}, "r1");
  ASSERT_TRUE(second.ok());
  EXPECT_FALSE(second->replayed);
}

TEST_F(MeshHostTest, ARetryOfACompactedRevisionHasNoColumns) {
  MeshHost::Options options;
  options.history.revisions = 1;
  const auto host = MakeHost(options);
  ASSERT_TRUE(Apply(*host, {AddPoint(1)}, "r1").ok());
  ASSERT_TRUE(Apply(*host, {AddPoint(2)}).ok());
  ASSERT_TRUE(Apply(*host, {AddPoint(3)}).ok());
  ASSERT_TRUE(host->store()->Latest().ok());  // the base moves on, the past may go
  ASSERT_GT(host->store()->oldest(), 1u);
  const Result again = Apply(*host, {AddPoint(1)}, "r1");
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(again->replayed);
  EXPECT_TRUE(again->columns_omitted);
  EXPECT_EQ(again->diff->from_revision, 0u);
  EXPECT_EQ(again->diff->to_revision, 1u);
}

TEST_F(MeshHostTest, OnlyTheLastRequestsAreRemembered) {
  MeshHost::Options options;
  options.remembered_requests = 2;
  const auto host = MakeHost(options);
  ASSERT_TRUE(Apply(*host, {AddPoint(1)}, "r1").ok());
  ASSERT_TRUE(Apply(*host, {AddPoint(2)}, "r2").ok());
  ASSERT_TRUE(Apply(*host, {AddPoint(3)}, "r3").ok());
  EXPECT_TRUE(Apply(*host, {AddPoint(2)}, "r2")->replayed);
  EXPECT_TRUE(Apply(*host, {AddPoint(3)}, "r3")->replayed);
  // r1 is forgotten, so its edits are new ones, and clash.
  EXPECT_EQ(ReasonOf(Apply(*host, {AddPoint(1)}, "r1").status()), reason::kIdInUse);
}

TEST_F(MeshHostTest, ValidateOnlyChangesNothingAndIsNotRemembered) {
  const auto host = MakeHost();
  EditJob job;
  job.edits = {AddPoint(1)};
  job.request_id = "r1";
  job.validate_only = true;
  const Result checked = Apply(*host, job);
  ASSERT_TRUE(checked.ok());
  EXPECT_EQ(checked->diff->from_revision, checked->diff->to_revision);
  EXPECT_EQ(host->head().revision, 0u);
  job.validate_only = false;
  const Result applied = Apply(*host, job);
  ASSERT_TRUE(applied.ok());
  EXPECT_FALSE(applied->replayed);
  job.validate_only = true;
  job.edits = {Edit::Remove(5)};
  EXPECT_EQ(ReasonOf(Apply(*host, job).status()), reason::kUnknownFeature);
}

TEST_F(MeshHostTest, ABatchCancelledWhileItRunsChangesNothing) {
  const auto host = MakeHost();
  const Head before = host->head();
  gate_->Hold();
  const auto cancelled = std::make_shared<std::atomic<bool>>(false);
  EditJob job;
  job.edits = {AddPoint(1)};
  job.cancelled = cancelled;
  Mailbox<Result> box;
  ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  gate_->WaitForArrivals(1);
  cancelled->store(true);
  EXPECT_EQ(box.Take().status().code(), absl::StatusCode::kCancelled);
  gate_->Release();
  EXPECT_EQ(host->head().revision, before.revision);
  EXPECT_EQ(host->head().hash, before.hash);
  EXPECT_TRUE(Apply(*host, {AddPoint(1)}).ok());
}

TEST_F(MeshHostTest, ABatchCancelledBeforeItsTurnIsNotTried) {
  const auto host = MakeHost();
  gate_->Hold();
  Mailbox<Result> first, second;
  EditJob job;
  job.edits = {AddPoint(1)};
  ASSERT_TRUE(Submit(*host, std::move(job), first).ok());
  gate_->WaitForArrivals(1);
  EditJob waiting;
  waiting.edits = {AddPoint(2)};
  waiting.cancelled = std::make_shared<std::atomic<bool>>(true);
  ASSERT_TRUE(Submit(*host, std::move(waiting), second).ok());
  gate_->Release();
  EXPECT_TRUE(first.Take().ok());
  EXPECT_EQ(second.Take().status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(host->head().revision, 1u);
}

TEST_F(MeshHostTest, WhatComesAfterAStopIsNotApplied) {
  const auto host = MakeHost();
  const auto stop = std::make_shared<std::atomic<bool>>(false);
  Mailbox<Result> box;
  for (const EditBatch& batch :
       {EditBatch{AddPoint(1)}, EditBatch{Edit::Remove(9)}, EditBatch{AddPoint(2)}}) {
    EditJob job;
    job.edits = batch;
    job.stop = stop;
    ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  }
  EXPECT_TRUE(box.Take().ok());
  EXPECT_EQ(ReasonOf(box.Take().status()), reason::kUnknownFeature);
  EXPECT_EQ(box.Take().status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(host->head().revision, 1u);
}

TEST_F(MeshHostTest, AFullQueueRefusesWithATimeToTryAgain) {
  MeshHost::Options options;
  options.max_waiting = 2;
  const auto host = MakeHost(options);
  gate_->Hold();
  Mailbox<Result> box;
  const auto submit = [&](FeatureId id) {
    EditJob job;
    job.edits = {AddPoint(id)};
    return Submit(*host, std::move(job), box);
  };
  ASSERT_TRUE(submit(1).ok());
  gate_->WaitForArrivals(1);  // it runs and waits no more
  ASSERT_TRUE(submit(2).ok());
  ASSERT_TRUE(submit(3).ok());
  EXPECT_EQ(host->waiting(), 2u);
  const absl::Status full = submit(4);
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(full), codec::reason::kQueueFull);
  EXPECT_TRUE(codec::GetServiceError(full)->retry_after.has_value());
  gate_->Release();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(box.Take().ok());
  EXPECT_EQ(host->head().revision, 3u);
}

TEST_F(MeshHostTest, AClosedHostRefusesWhatWaits) {
  const auto host = MakeHost();
  gate_->Hold();
  Mailbox<Result> box;
  for (FeatureId id : {1, 2}) {
    EditJob job;
    job.edits = {AddPoint(id)};
    ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  }
  gate_->WaitForArrivals(1);
  host->Close(absl::NotFoundError("gone"));
  gate_->Release();
  EXPECT_TRUE(box.Take().ok());  // it ran already
  EXPECT_EQ(box.Take().status().code(), absl::StatusCode::kNotFound);
}

TEST_F(MeshHostTest, MeshesRunInParallel) {
  const auto held = MakeHost();
  gate_->Hold();
  Mailbox<Result> box;
  EditJob job;
  job.edits = {AddPoint(1)};
  ASSERT_TRUE(Submit(*held, std::move(job), box).ok());
  gate_->WaitForArrivals(1);
  const auto free =
      MeshHost::Create("n", *MakeFake(MeshOptions()), absl::UnixEpoch(), &writers_, &readers_, {});
  EXPECT_TRUE(Apply(*free, {AddPoint(1)}).ok());
  gate_->Release();
  EXPECT_TRUE(box.Take().ok());
}

TEST_F(MeshHostTest, ReadersDoNotWaitForTheWriter) {
  const auto host = MakeHost();
  ASSERT_TRUE(Apply(*host, {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  gate_->Hold();
  Mailbox<Result> box;
  EditJob job;
  job.edits = {AddPoint(4)};
  ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  gate_->WaitForArrivals(2);
  EXPECT_EQ(host->head().revision, 1u);
  EXPECT_EQ(host->stats().features, 3u);
  const auto mesh = host->store()->Latest();
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ((*mesh)->revision, 1u);
  EXPECT_EQ(ComputeHash(**mesh), (*mesh)->hash);
  gate_->Release();
  EXPECT_TRUE(box.Take().ok());
}

TEST_F(MeshHostTest, LocateAnswersInTurnWithTheEdits) {
  const auto host = MakeHost();
  gate_->Hold();
  Mailbox<Result> box;
  EditJob job;
  job.edits = {AddPoint(1), AddPoint(2), AddPoint(3)};
  ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  Mailbox<absl::StatusOr<MeshHost::LocateAnswer>> answers;
  ASSERT_TRUE(
      host->Locate({0.5, 0.5, 7, 7}, nullptr, [&](auto a) { answers.Put(std::move(a)); }).ok());
  gate_->Release();
  const auto answer = answers.Take();
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->revision, 1u);
  ASSERT_EQ(answer->simplices.size(), 6u);
  EXPECT_NE(answer->simplices[0], 0u);
  EXPECT_EQ(answer->simplices[3], 0u);
}

TEST_F(MeshHostTest, ABatchThatTakesLongIsReportedOnceAnInterval) {
  const auto host = MakeHost();
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  host->ReportLongWork(absl::ZeroDuration());  // nothing runs
  gate_->Hold();
  Mailbox<Result> box;
  EditJob job;
  job.edits = {AddPoint(1), AddPoint(2)};
  job.call_id = "slow-1";
  ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  gate_->WaitForArrivals(1);
  host->ReportLongWork(absl::Hours(1));
  host->ReportLongWork(absl::ZeroDuration());
  host->ReportLongWork(absl::Hours(1));
  gate_->Release();
  ASSERT_TRUE(box.Take().ok());
  host->ReportLongWork(absl::ZeroDuration());
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("error").ok());
  const std::string line = "event=edit_running mesh=m call=slow-1 edits=2 ";
  const std::size_t at = log.find(line);
  ASSERT_NE(at, std::string::npos) << log;
  EXPECT_EQ(log.find("event=edit_running", at + 1), std::string::npos) << log;
  EXPECT_NE(log.find(" stage=propagate done=2 total=4 ", at), std::string::npos) << log;
}

TEST_F(MeshHostTest, TellsHowFarItsBatchIs) {
  const auto host = MakeHost();
  EXPECT_FALSE(host->running().has_value());
  gate_->Hold();
  Mailbox<Result> box;
  EditJob job;
  job.edits = {AddPoint(1), AddPoint(2), AddPoint(3)};
  std::vector<BatchProgress> told;
  job.progress = [&told](const BatchProgress& progress) { told.push_back(progress); };
  ASSERT_TRUE(Submit(*host, std::move(job), box).ok());
  gate_->WaitForArrivals(1);
  const auto running = host->running();
  ASSERT_TRUE(running.has_value());
  EXPECT_EQ(running->edits, 3u);
  EXPECT_EQ(running->progress.stage, BatchProgress::Stage::kRefine);
  EXPECT_EQ(running->progress.done, 3u);
  EXPECT_EQ(running->progress.total, 6u);
  gate_->Release();
  ASSERT_TRUE(box.Take().ok());
  // Another job's progress is its own.
  ASSERT_TRUE(Apply(*host, {AddPoint(4)}).ok());
  EXPECT_FALSE(host->running().has_value());
  ASSERT_EQ(told.size(), 5u);
  EXPECT_EQ(told.back().stage, BatchProgress::Stage::kDiff);
}

// Has another hash than it should after one batch.
class ForgetfulMesh final : public MeshDecorator {
 public:
  ForgetfulMesh(std::unique_ptr<DynamicMesh> mesh, bool after_refusal)
      : MeshDecorator(std::move(mesh)), after_refusal_(after_refusal) {}
  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const ApplyOptions& options) override {
    auto diff = mesh_->Apply(batch, options);
    is_other_ = is_other_ || diff.ok() != after_refusal_;
    return diff;
  }
  MeshHash hash() const override { return is_other_ ? MeshHash{1, 2} : mesh_->hash(); }

 private:
  const bool after_refusal_;
  bool is_other_ = false;
};

TEST_F(MeshHostTest, IsClosedIfItsMeshIsNotAsItShouldBe) {
  for (const bool after_refusal : {false, true}) {
    const auto host = MeshHost::Create(
        "m", std::make_unique<ForgetfulMesh>(*MakeFake(MeshOptions(), gate_), after_refusal),
        absl::UnixEpoch(), &writers_, &readers_, {});
    const Result first = Apply(*host, {AddPoint(1)});
    EXPECT_EQ(first.ok(), after_refusal) << Text(first.status());
    const Result second = Apply(*host, {AddPoint(1)});  // its id is in use
    EXPECT_EQ(second.status().code(), absl::StatusCode::kInternal);
    EXPECT_NE(second.status().message().find("can no longer be followed"), std::string::npos);
    EXPECT_EQ(host->head().revision, after_refusal ? 1u : 0u);  // the last good one
  }
}

}  // namespace
}  // namespace dynmesh::server::mesh_host_test
