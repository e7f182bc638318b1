// Groups of batches that cannot be written: they are undone, to the former trace, and the journal
// has what was acknowledged.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/journal_codec.h"
#include "tests/server/meshes/edit_group_fixture.h"
#include "tests/server/meshes/mesh_decorator.h"

namespace dynmesh::server {
namespace {

// An undone batch leaves no trace, in the mesh's trace either.
TEST_F(EditGroupTest, OneThatIsUndoneBringsTheFormerTraceBack) {
  std::vector<MeshHash> traces;
  const auto host =
      MakeHostOf(std::make_unique<WatchedMesh>(*DynamicMesh::Create(MeshOptions()), &traces));
  std::mt19937 random(1);
  const auto unit = [&] { return static_cast<double>(random() % 10'007) / 10'007; };
  EditBatch many;
  for (FeatureId id = 1; id <= 300; ++id)
    many.push_back(Edit::Add(Feature::Point(id, unit(), unit())));
  Hand(*host, Job(many));
  ASSERT_TRUE(Next().ok());
  const Head head = host->head();
  for (int round = 0; round < 5; ++round) {
    SCOPED_TRACE(round);
    journal_.Answer([](int) { return DiskFull(); });
    traces.clear();
    std::vector<EditJob> jobs;
    for (FeatureId id = 1; id <= 20; ++id) {
      jobs.push_back(
          Job({Edit::Add(Feature::Point(1000 + id, unit(), unit())), Edit::Move(id, unit(), unit()),
               Edit::Remove(20 * static_cast<FeatureId>(round + 1) + id)}));
    }
    HandAll(*host, std::move(jobs));
    for (int i = 0; i < 20; ++i) ExpectJournalFailed(Next());
    EXPECT_EQ(host->head().hash, head.hash);
    const MeshHash before = traces.front();
    EXPECT_NE(traces.back(), before);
    Hand(*host, Job({}));
    ASSERT_TRUE(Next().ok());
    EXPECT_EQ(traces.back(), before);
  }
}

// A random script in groups, with one append after the other failing, once or from then on: the
// answers match the journal, and the journal's batches make the host's mesh.
class FailAtEveryAppend : public EditGroupTest,
                          public ::testing::WithParamInterface<std::tuple<int, bool>> {
 protected:
  // Some jobs, now and then a retry of the one before.
  std::vector<EditJob> RandomJobs(std::mt19937& random) {
    std::vector<EditJob> jobs;
    for (std::size_t size = 1 + random() % 6; jobs.size() < size;) {
      if (!jobs.empty() && random() % 4 == 0) {
        jobs.push_back(Job(jobs.back().edits, jobs.back().request_id));
        continue;
      }
      const FeatureId some = 1 + random() % next_;
      EditBatch edits = {random() % 3 == 0 ? Edit::Remove(some) : AddPoint(next_++)};
      if (random() % 8 == 0) edits.clear();
      jobs.push_back(Job(edits, absl::StrCat("r", ++requests_)));
    }
    return jobs;
  }
  void RunGroup(MeshHost& host, std::mt19937& random) {
    std::vector<EditJob> jobs = RandomJobs(random);
    std::vector<std::string> ids;
    for (const EditJob& job : jobs) ids.push_back(job.request_id);
    HandAll(host, std::move(jobs));
    bool failed = false, done = false;
    for (const std::string& id : ids) {
      const Result result = Next();
      failed = failed || ReasonOf(result.status()) == codec::reason::kJournalFailed;
      if (!result.ok()) continue;
      done = true;
      if (result->replayed) {
        EXPECT_EQ(acknowledged_.at(id), result->diff->to_revision);
        continue;
      }
      EXPECT_EQ(result->diff->from_revision, revision_);
      revision_ = acknowledged_[id] = result->diff->to_revision;
    }
    EXPECT_FALSE(failed && done);  // all or none
    EXPECT_EQ(host.head().revision, revision_);
  }
  void ExpectWhatTheJournalHas(const MeshHost& host) {
    const auto mesh = *MakeFake(MeshOptions());
    std::size_t requests = 0;
    for (const auto& group : journal_.groups()) {
      for (const auto& entry : group.entries) {
        const auto batch = codec::DecodeJournalEntry(entry.data, 2);
        ASSERT_TRUE(batch.ok());
        ASSERT_TRUE(mesh->Apply(batch->edits, {}).ok());
        EXPECT_EQ(mesh->revision(), entry.revision);
        EXPECT_EQ(mesh->hash(), batch->hash);
      }
      for (const auto& request : group.requests) {
        EXPECT_TRUE(acknowledged_.contains(request.id)) << request.id;
        ++requests;
      }
    }
    EXPECT_EQ(requests, acknowledged_.size());
    EXPECT_EQ(host.head().revision, mesh->revision());
    EXPECT_EQ(host.head().hash, mesh->hash());
    EXPECT_EQ(host.stats().features, mesh->Stats().features);
    EXPECT_EQ((*host.store()->Latest())->hash, mesh->hash());
  }

  FeatureId next_ = 1;
  int requests_ = 0;
  std::uint64_t revision_ = 0;
  std::map<std::string, std::uint64_t> acknowledged_;  // revision by request
};

TEST_P(FailAtEveryAppend, AcknowledgesWhatTheJournalHas) {
  const auto [at, ever] = GetParam();
  const unsigned seed = 100u + static_cast<unsigned>(at);
  SCOPED_TRACE(absl::StrCat("append ", at, " fails, seed ", seed));
  std::mt19937 random(seed);
  journal_.Answer([at = at, ever = ever](int n) {
    return n == at || (ever && n > at) ? DiskFull() : absl::OkStatus();
  });
  const auto host = MakeHost();
  for (int group = 0; group < 25 && !HasFailure(); ++group) RunGroup(*host, random);
  ExpectWhatTheJournalHas(*host);
  journal_.Answer(nullptr);  // it works again
  for (int group = 0; group < 5 && !HasFailure(); ++group) RunGroup(*host, random);
  ExpectWhatTheJournalHas(*host);
  EXPECT_GT(journal_.appends(), at);
}

INSTANTIATE_TEST_SUITE_P(OnceAndForGood, FailAtEveryAppend,
                         ::testing::Combine(::testing::Range(1, 21), ::testing::Bool()));

}  // namespace
}  // namespace dynmesh::server
