// Batches that are written together: no client sees one before it is written, and if the write
// fails, all of them are undone and refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"
#include "tests/server/meshes/edit_group_fixture.h"

namespace dynmesh::server {
namespace {

using absl::StatusCode;
using Sizes = std::vector<std::size_t>;

TEST_F(EditGroupTest, OneAloneIsWrittenDownAtOnce) {
  const auto host = MakeHost();
  for (FeatureId id = 1; id <= 3; ++id) {
    EditJob job = Job({AddPoint(id)});
    std::atomic<std::thread::id> applied;
    job.progress = [&](const BatchProgress&) { applied = std::this_thread::get_id(); };
    Hand(*host, std::move(job));
    EXPECT_TRUE(Next().ok());
    EXPECT_EQ(journal_.thread(), applied.load());  // no other was woken
  }
  EXPECT_EQ(journal_.sizes(), (Sizes{1, 1, 1}));
}

TEST_F(EditGroupTest, ThoseThatWaitAreWrittenDownTogetherAndAnsweredInOrder) {
  const auto host = MakeHost();
  std::vector<EditJob> jobs;
  for (FeatureId id = 1; id <= 50; ++id) jobs.push_back(Job({AddPoint(id)}, absl::StrCat("r", id)));
  HandAll(*host, std::move(jobs));
  for (std::uint64_t revision = 1; revision <= 50; ++revision) {
    const Result result = Next();
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->diff->to_revision, revision);
  }
  ASSERT_EQ(journal_.sizes(), (Sizes{50}));
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(journal_.groups()[0].entries[i].revision, i + 1);
    EXPECT_EQ(journal_.groups()[0].requests[i].id, absl::StrCat("r", i + 1));
  }
  EXPECT_EQ(host->head().revision, 50u);
}

TEST_F(EditGroupTest, NobodySeesWhatIsNotWrittenDown) {
  const auto host = MakeHost();
  Hand(*host, Job({AddPoint(1)}));
  ASSERT_TRUE(Next().ok());
  journal_.Hold();
  HandAll(*host, {Job({AddPoint(2)}), Job({AddPoint(3)}), Job({AddPoint(2)}), Job({})});
  journal_.WaitForAppends(2);
  ExpectHead(*host, 1, {1});
  EXPECT_EQ(answers_.size(), 0u);
  EXPECT_EQ(host->running()->progress.stage, BatchProgress::Stage::kJournal);
  journal_.Release();
  EXPECT_TRUE(Next().ok());
  EXPECT_TRUE(Next().ok());
  EXPECT_EQ(ReasonOf(Next().status()), reason::kIdInUse);
  EXPECT_EQ(Next()->diff->to_revision, 3u);
  ExpectHead(*host, 3, {1, 2, 3});
}

TEST_F(EditGroupTest, OneThatCannotBeWrittenDownIsUndoneAsAWhole) {
  const auto host = MakeHost();
  Hand(*host, Job({AddPoint(1)}));
  ASSERT_TRUE(Next().ok());
  journal_.Answer([](int n) { return n == 2 ? DiskFull() : absl::OkStatus(); });
  HandAll(*host, {Job({AddPoint(2)}, "a"), Job({Edit::Remove(1)}, "b"), Job({AddPoint(4)})});
  for (int i = 0; i < 3; ++i) ExpectJournalFailed(Next());
  ExpectHead(*host, 1, {1});
  // Later batches begin there, and the ids of refused ones are free.
  HandAll(*host, {Job({AddPoint(2)}, "a"), Job({AddPoint(3)}, "b")});
  for (std::uint64_t revision = 2; revision <= 3; ++revision) {
    const Result result = Next();
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_FALSE(result->replayed);
    EXPECT_EQ(result->diff->to_revision, revision);
  }
  ExpectHead(*host, 3, {1, 2, 3});
}

TEST_F(EditGroupTest, ARefusedBatchDoesNotDisturbTheOthers) {
  const auto host = MakeHost();
  const auto jobs = [this](FeatureId first) {
    EditJob bad = Job({});
    bad.refused = absl::InvalidArgumentError("cannot be read");
    return std::vector<EditJob>{Job({AddPoint(first)}), Job({AddPoint(first)}), std::move(bad),
                                Job({AddPoint(first + 1)})};
  };
  HandAll(*host, jobs(1));
  EXPECT_EQ(Next()->diff->to_revision, 1u);
  EXPECT_EQ(ReasonOf(Next().status()), reason::kIdInUse);
  EXPECT_EQ(Next().status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Next()->diff->to_revision, 2u);
  EXPECT_EQ(journal_.sizes(), (Sizes{2}));
  // The id was in use only because of a batch that is undone.
  journal_.Answer([](int) { return DiskFull(); });
  HandAll(*host, jobs(3));
  ExpectJournalFailed(Next());
  ExpectJournalFailed(Next());
  EXPECT_EQ(Next().status().code(), StatusCode::kInvalidArgument);
  ExpectJournalFailed(Next());
  ExpectHead(*host, 2, {1, 2});
}

TEST_F(EditGroupTest, ARetryIsKnownBeforeTheFirstIsWrittenDown) {
  const auto host = MakeHost();
  const auto jobs = [this] {
    return std::vector<EditJob>{Job({AddPoint(1)}, "r"), Job({AddPoint(1)}, "r"),
                                Job({AddPoint(2)}, "r"), Job({}, "empty"), Job({}, "empty")};
  };
  journal_.Answer([](int) { return DiskFull(); });
  HandAll(*host, jobs());
  for (int i = 0; i < 5; ++i) ExpectJournalFailed(Next());
  journal_.Answer(nullptr);
  HandAll(*host, jobs());
  const Result first = Next(), again = Next(), other = Next();
  ASSERT_TRUE(first.ok() && again.ok());
  EXPECT_FALSE(first->replayed);
  EXPECT_TRUE(again->replayed);
  EXPECT_EQ(again->diff, first->diff);
  EXPECT_EQ(ReasonOf(other.status()), codec::reason::kRequestIdReused);
  EXPECT_EQ(codec::GetServiceError(other.status())->metadata["revision"], "1");
  EXPECT_FALSE(Next()->replayed);
  EXPECT_TRUE(Next()->replayed);
  EXPECT_EQ(journal_.sizes(), (Sizes{1}));
  EXPECT_EQ(journal_.groups()[0].requests.size(), 2u);
}

TEST_F(EditGroupTest, ExpectedRevisionsAreThoseWithinTheGroup) {
  const auto host = MakeHost();
  std::vector<EditJob> jobs;
  for (FeatureId id = 1; id <= 4; ++id) {
    jobs.push_back(Job({AddPoint(id)}));
    jobs.back().expected_revision = id == 3 ? 7 : id < 3 ? id - 1 : 2;
  }
  HandAll(*host, std::move(jobs));
  EXPECT_TRUE(Next().ok());
  EXPECT_TRUE(Next().ok());
  const absl::Status stale = Next().status();
  EXPECT_EQ(ReasonOf(stale), codec::reason::kRevisionMismatch);
  EXPECT_EQ(codec::GetServiceError(stale)->metadata["revision"], "2");
  EXPECT_EQ(Next()->diff->to_revision, 3u);
  EXPECT_EQ(journal_.sizes(), (Sizes{3}));
}

TEST_F(EditGroupTest, OneThatIsCancelledOrOnlyValidatedChangesNothing) {
  const auto host = MakeHost();
  const auto flag = std::make_shared<std::atomic<bool>>(false);
  std::vector<EditJob> jobs;
  for (FeatureId id = 1; id <= 4; ++id) jobs.push_back(Job({AddPoint(id)}));
  jobs[1].cancelled = flag;  // in the middle of it
  jobs[1].progress = [&](const BatchProgress&) { flag->store(true); };
  jobs[2].validate_only = true;
  HandAll(*host, std::move(jobs));
  EXPECT_EQ(Next()->diff->to_revision, 1u);
  EXPECT_EQ(Next().status().code(), StatusCode::kCancelled);
  EXPECT_EQ(Next()->diff->to_revision, 1u);
  EXPECT_EQ(Next()->diff->to_revision, 2u);
  EXPECT_EQ(journal_.sizes(), (Sizes{2}));
  ExpectHead(*host, 2, {1, 4});
}

TEST_F(EditGroupTest, OneThatIsCancelledWhenItIsAppliedIsWrittenDown) {
  const auto host = MakeHost();
  journal_.Hold();
  const auto flag = std::make_shared<std::atomic<bool>>(false);
  std::vector<EditJob> jobs = {};
  for (FeatureId id = 1; id <= 2; ++id) {
    jobs.push_back(Job({AddPoint(id)}));
    jobs.back().cancelled = flag;
  }
  HandAll(*host, std::move(jobs));
  journal_.WaitForAppends(1);
  flag->store(true);
  host->Withdraw(flag);
  journal_.Release();
  EXPECT_TRUE(Next().ok());
  EXPECT_TRUE(Next().ok());
}

TEST_F(EditGroupTest, AStreamThatEndsAtTheFirstRefusedBatchEndsThere) {
  const auto host = MakeHost();
  const auto stop = std::make_shared<std::atomic<bool>>(false);
  const auto jobs = [&] {
    std::vector<EditJob> made;
    for (const FeatureId id : {1, 1, 2}) {
      made.push_back(Job({AddPoint(id)}));
      made.back().stop = stop;
    }
    return made;
  };
  HandAll(*host, jobs());
  EXPECT_TRUE(Next().ok());
  EXPECT_EQ(ReasonOf(Next().status()), reason::kIdInUse);
  EXPECT_EQ(Next().status().code(), StatusCode::kCancelled);
  // A batch with a failed write counts as refused, too.
  stop->store(false);
  journal_.Answer([](int) { return DiskFull(); });
  std::vector<EditJob> more;
  for (const FeatureId id : {2, 3}) {
    more.push_back(Job({AddPoint(id)}));
    more.back().stop = stop;
  }
  HandAll(*host, std::move(more));
  ExpectJournalFailed(Next());
  ExpectJournalFailed(Next());
  EXPECT_TRUE(stop->load());
}

TEST_F(EditGroupTest, EndsBeforeWhatIsToSeeTheMeshAsItIsWrittenDown) {
  const auto host = MakeHost();
  EditBatch large;
  for (FeatureId id = 100; id < 200; ++id) large.push_back(AddPoint(id));
  EditJob made = Job({});
  made.make = [](const DynamicMesh& mesh) -> absl::StatusOr<EditBatch> {
    EXPECT_EQ(mesh.revision(), 3u);
    return EditBatch{AddPoint(4)};
  };
  HandAll(*host, {Job({AddPoint(1)}), Job({AddPoint(2)}), Job(large), std::move(made),
                  Job({AddPoint(5)}), Job({AddPoint(6)})});
  for (std::uint64_t revision = 1; revision <= 6; ++revision) {
    EXPECT_EQ(Next()->diff->to_revision, revision);
  }
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 1, 1, 2}));

  Mailbox<absl::StatusOr<MeshHost::LocateAnswer>> located;
  gate_->Hold();
  journal_.Hold();
  Hand(*host, Job({AddPoint(7)}));
  ASSERT_TRUE(host->Locate({0.5, 0.5}, nullptr, [&](auto answer) { located.Put(answer); }).ok());
  Hand(*host, Job({AddPoint(8)}));
  gate_->Release();
  journal_.WaitForAppends(5);
  EXPECT_EQ(located.size(), 0u);
  journal_.Release();
  EXPECT_EQ(located.Take()->revision, 7u);
  EXPECT_TRUE(Next().ok());
  EXPECT_TRUE(Next().ok());
  EXPECT_EQ(journal_.sizes(), (Sizes{2, 1, 1, 2, 1, 1}));
}

TEST_F(EditGroupTest, TheFirstIsNoLargerThanATurn) {
  options_.turn.tasks = 4;
  const auto host = MakeHost();
  journal_.Hold();
  std::vector<EditJob> jobs;
  for (FeatureId id = 1; id <= 10; ++id) jobs.push_back(Job({AddPoint(id)}));
  HandAll(*host, std::move(jobs));
  journal_.WaitForAppends(1);
  gate_->WaitForArrivals(10);  // the others are applied meanwhile
  journal_.Release();
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(Next().ok());
  EXPECT_EQ(journal_.sizes(), (Sizes{3, 7}));
}

TEST_F(EditGroupTest, OfAMeshThatIsDeletedMeanwhileIsRefused) {
  const auto host = MakeHost();
  journal_.Answer([](int) { return absl::NotFoundError("no such mesh"); });
  HandAll(*host, {Job({AddPoint(1)}), Job({AddPoint(2)})});
  EXPECT_EQ(ReasonOf(Next().status()), codec::reason::kMeshDeleted);
  EXPECT_EQ(ReasonOf(Next().status()), codec::reason::kMeshDeleted);
  EXPECT_EQ(host->head().revision, 0u);
}

TEST_F(EditGroupTest, IsAnsweredAlsoIfTheHostIsClosedAndLetGoMeanwhile) {
  auto host = MakeHost();
  journal_.Hold();
  HandAll(*host, {Job({AddPoint(1)}), Job({AddPoint(2)})});
  journal_.WaitForAppends(1);
  host->Close(absl::UnavailableError("the server ends"));
  Hand(*host, Job({AddPoint(3)}));
  host.reset();
  journal_.Release();
  EXPECT_TRUE(Next().ok());
  EXPECT_TRUE(Next().ok());
  EXPECT_EQ(Next().status().message(), "the server ends");
  EXPECT_EQ(journal_.sizes(), (Sizes{2}));
}

TEST_F(EditGroupTest, CountsTheFeaturesBeforeItAgainstTheLimit) {
  options_.max_features = 3;
  const auto host = MakeHost();
  std::vector<EditJob> jobs;
  for (FeatureId id = 1; id <= 4; ++id) jobs.push_back(Job({AddPoint(id)}));
  jobs.push_back(Job({Edit::Remove(1)}));
  jobs.push_back(Job({AddPoint(5)}));
  HandAll(*host, std::move(jobs));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(Next().ok());
  EXPECT_EQ(ReasonOf(Next().status()), codec::reason::kFeatureLimit);
  EXPECT_TRUE(Next().ok());
  EXPECT_TRUE(Next().ok());
  ExpectHead(*host, 5, {2, 3, 5});
}

}  // namespace
}  // namespace dynmesh::server
