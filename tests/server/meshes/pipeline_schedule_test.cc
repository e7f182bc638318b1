// Random jobs for a host, beside appends that end at random moments, well or not. The answers, in
// their order, are those of a mesh that does one after the other, each on the disk before its
// answer; afterwards mesh and trace are those of a run from scratch.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"
#include "proto/codec/journal_codec.h"
#include "tests/server/meshes/edit_group_fixture.h"
#include "tests/server/meshes/mesh_decorator.h"

namespace dynmesh::server {
namespace {

struct Schedule {
  unsigned seed;
  bool real;    // the real mesher
  bool stream;  // many jobs to each append
};

class PipelineSchedule : public EditGroupTest, public ::testing::WithParamInterface<Schedule> {
 protected:
  enum class Kind { kEdit, kLocate };
  // A job as the oracle sees it.
  struct Asked {
    Kind kind = Kind::kEdit;
    EditBatch edits;
    std::string id;
    std::optional<std::uint64_t> expected;
    bool validate_only = false;
    bool may_be_cancelled = false;
  };
  struct Answered {
    std::size_t number = 0;
    Result result;
    std::uint64_t revision = 0;   // of a query
    std::uint64_t on_disk = 0;    // the journal's last revision at that moment
    std::uint64_t published = 0;  // the head then
  };

  PipelineSchedule() : random_(GetParam().seed) {
    const std::size_t limits[] = {2, 5, 1'024};
    options_.held.edits = limits[random_() % 3];
    options_.turn = {1 + static_cast<int>(random_() % 40), std::chrono::hours(1)};
    options_.long_batch = std::chrono::hours(random_() % 2);
    if (OneIn(2)) options_.compact = {200, 200};
    mesh_ = NewMesh();
    traces_.reserve(100'000);
    host_ = MakeHostOf(std::make_unique<WatchedMesh>(NewMesh(), &traces_));
    journal_.Hold();
    journal_.Answer([seed = GetParam().seed](int n) {
      std::mt19937 dice(seed * 1'000 + static_cast<unsigned>(n));
      return dice() % 5 == 0 ? DiskFull() : absl::OkStatus();
    });
  }
  ~PipelineSchedule() override {
    journal_.Release();
    snapshots_->Stop();
    writers_.Stop();  // before what the answers are put into
  }

  static std::unique_ptr<DynamicMesh> NewMesh() {
    return GetParam().real ? *DynamicMesh::Create(MeshOptions()) : *MakeFake(MeshOptions());
  }
  bool OneIn(unsigned n) { return random_() % n == 0; }
  FeatureId SomePoint() { return 1 + random_() % next_; }

  EditBatch RandomEdits() {
    if (OneIn(8)) return {};
    EditBatch edits;
    if (OneIn(30)) {  // too large to be held
      while (edits.size() < 65) edits.push_back(AddPoint(next_++));
      return edits;
    }
    for (std::size_t size = 1 + random_() % 3; edits.size() < size;) {
      edits.push_back(OneIn(3) ? Edit::Remove(SomePoint()) : AddPoint(next_++));
    }
    if (OneIn(6)) edits.push_back(AddPoint(SomePoint()));  // refused, if it is there
    return edits;
  }

  void HandOne() {
    const std::size_t number = asked_.size();
    Asked asked;
    if (OneIn(15)) {
      asked.kind = Kind::kLocate;
      asked_.push_back(asked);
      EXPECT_TRUE(host_
                      ->Locate({0.5, 0.5}, nullptr,
                               [this, number](const auto& answer) {
                                 ASSERT_TRUE(answer.ok());
                                 Note(number, EditOutcome(), answer->revision);
                               })
                      .ok());
      return;
    }
    asked.edits = RandomEdits();
    if (!OneIn(3)) asked.id = absl::StrCat("r", number);
    if (number > 0 && OneIn(6)) {
      const Asked& earlier = asked_[random_() % number];
      asked.id = earlier.id;
      if (!OneIn(4)) asked.edits = earlier.edits;
    }
    if (OneIn(10)) asked.expected = host_->head().revision + random_() % 4;
    asked.validate_only = OneIn(20);
    EditJob job = Job(asked.edits, asked.id);
    job.expected_revision = asked.expected;
    job.validate_only = asked.validate_only;
    if (OneIn(10)) {
      asked.may_be_cancelled = true;
      job.cancelled = std::make_shared<std::atomic<bool>>(false);
      flags_.push_back(std::const_pointer_cast<std::atomic<bool>>(job.cancelled));
    }
    asked_.push_back(asked);
    job.done = [this, number](Result result) { Note(number, std::move(result), 0); };
    host_->ApplyUnbounded(std::move(job));
  }

  void Note(std::size_t number, Result result, std::uint64_t revision) {
    log_.Put({number, std::move(result), revision, journal_.last(), host_->head().revision});
  }

  void CancelOne() {
    if (flags_.empty()) return;
    const auto flag = flags_[random_() % flags_.size()];
    flag->store(true);
    host_->Withdraw(flag);
  }

  // Checks an answer against the oracle, and takes it over.
  void Judge(const Answered& answered) {
    const Asked& asked = asked_[answered.number];
    SCOPED_TRACE(absl::StrCat("answer ", answered.number));
    const Result& result = answered.result;
    ASSERT_TRUE(answers_of_.insert(answered.number).second) << "answered twice";
    if (asked.may_be_cancelled && absl::IsCancelled(result.status())) return;
    // Only those that are withdrawn may be early.
    ASSERT_TRUE(newest_ <= answered.number) << "after " << newest_;
    newest_ = answered.number;
    EXPECT_LE(answered.published, answered.on_disk);
    if (asked.kind == Kind::kLocate) {
      EXPECT_EQ(answered.revision, mesh_->revision());
      return;
    }
    if (ReasonOf(result.status()) == codec::reason::kJournalFailed) {
      ++failed_;
      return;
    }
    const auto before = asked.validate_only ? durable_.end() : durable_.find(asked.id);
    if (!asked.id.empty() && before != durable_.end()) {
      const bool same = FingerprintOf(before->second.edits) == FingerprintOf(asked.edits);
      if (!same) {
        EXPECT_EQ(ReasonOf(result.status()), codec::reason::kRequestIdReused);
        return;
      }
      ASSERT_TRUE(result.ok()) << result.status();
      EXPECT_TRUE(result->replayed);
      EXPECT_EQ(result->diff->to_revision, before->second.revision);
      return;
    }
    if (asked.expected.has_value() && *asked.expected != mesh_->revision()) {
      EXPECT_EQ(codec::GetServiceError(result.status())->metadata["revision"],
                absl::StrCat(mesh_->revision()));
      return;
    }
    if (asked.validate_only) {
      EXPECT_EQ(result.ok(), mesh_->Validate(asked.edits).ok());
      return;
    }
    const auto applied = mesh_->Apply(asked.edits);
    ASSERT_EQ(result.ok(), applied.ok()) << result.status() << applied.status();
    if (!result.ok()) {
      EXPECT_EQ(result.status().code(), applied.status().code());
      return;
    }
    EXPECT_FALSE(result->replayed);
    EXPECT_EQ(result->diff->to_revision, applied->to_revision);
    EXPECT_EQ(result->diff->hash, applied->hash);
    EXPECT_GE(answered.on_disk, applied->to_revision);
    EXPECT_GE(answered.published, applied->to_revision);
    if (!asked.id.empty()) durable_[asked.id] = {asked.edits, applied->to_revision};
  }

  void JudgeAll() {
    while (answers_of_.size() < asked_.size() && !HasFatalFailure()) Judge(log_.Take());
    EXPECT_EQ(log_.size(), 0u);
  }

  void ExpectTheJournalsMesh() {
    const auto replayed = NewMesh();
    std::set<std::string> requests;
    for (const auto& group : journal_.groups()) {
      for (const auto& entry : group.entries) {
        const auto batch = codec::DecodeJournalEntry(entry.data, 2);
        ASSERT_TRUE(batch.ok());
        ASSERT_TRUE(replayed->Apply(batch->edits).ok());
        EXPECT_EQ(replayed->revision(), entry.revision);
        EXPECT_EQ(replayed->hash(), batch->hash);
      }
      for (const auto& request : group.requests) {
        EXPECT_TRUE(requests.insert(request.id).second) << request.id;
        EXPECT_TRUE(durable_.contains(request.id)) << request.id;
      }
    }
    EXPECT_EQ(requests.size(), durable_.size());
    EXPECT_EQ(host_->head().revision, replayed->revision());
    EXPECT_EQ(host_->head().hash, replayed->hash());
    EXPECT_EQ(mesh_->hash(), replayed->hash());
    EXPECT_EQ(host_->stats().features, replayed->Stats().features);
  }

  void ExpectTheTraceFromScratch() {
    Hand(*host_, Job({}));  // records the trace
    ASSERT_TRUE(Next().ok());
    const auto fresh = NewMesh();
    const std::vector<Feature> features = mesh_->Features();
    if (!features.empty()) {
      ASSERT_TRUE(fresh->Apply(AddAll(features)).ok());
    }
    EXPECT_EQ(host_->head().hash, fresh->hash());
    EXPECT_EQ(traces_.back(), fresh->Audit().trace);
  }

  struct Durable {
    EditBatch edits;
    std::uint64_t revision;
  };

  std::mt19937 random_;
  std::vector<MeshHash> traces_;
  std::shared_ptr<MeshHost> host_;
  FeatureId next_ = 1;
  std::vector<Asked> asked_;
  std::vector<std::shared_ptr<std::atomic<bool>>> flags_;
  Mailbox<Answered> log_;
  // The oracle.
  std::unique_ptr<DynamicMesh> mesh_;
  std::set<std::size_t> answers_of_;
  std::map<std::string, Durable> durable_;
  std::size_t newest_ = 0;
  int failed_ = 0;
};

TEST_P(PipelineSchedule, AnswersAreThoseOfOneAfterTheOther) {
  SCOPED_TRACE(absl::StrCat("seed ", GetParam().seed));
  const int steps = GetParam().real ? 300 : 600;
  const unsigned rarely = GetParam().stream ? 8 : 2;
  for (int step = 0; step < steps; ++step) {
    HandOne();
    if (OneIn(rarely)) journal_.ReleaseUpTo(journal_.appends());
    if (OneIn(12)) CancelOne();
    if (OneIn(20)) std::this_thread::yield();
  }
  journal_.Release();
  JudgeAll();
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_GT(failed_, 0);
  journal_.Answer(nullptr);
  ExpectTheJournalsMesh();
  ExpectTheTraceFromScratch();
}

std::vector<Schedule> Schedules() {
  std::vector<Schedule> all;
  for (unsigned seed = 1; seed <= 40; ++seed) all.push_back({seed, false, seed % 2 == 0});
  for (unsigned seed = 101; seed <= 106; ++seed) all.push_back({seed, true, seed % 2 == 0});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Seeds, PipelineSchedule, ::testing::ValuesIn(Schedules()),
                         [](const auto& given) { return absl::StrCat("Seed", given.param.seed); });

}  // namespace
}  // namespace dynmesh::server
