// Meshes of a shared journal are opened once, by the right server, for all calls that wait.
#include "server/meshes/mesh_opener.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <future>
#include <mutex>
#include <vector>

#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/cluster/placement.h"
#include "server/journal/journal_errors.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::mesh_opener_test {
namespace {

using Located = SharedJournal::Located;
using Result = absl::StatusOr<MeshOpener::HostPtr>;

// Answers Locate with these in turn, the last one again and again.
class ScriptedJournal final : public SharedJournal {
 public:
  absl::Duration lease() const override { return lease_; }
  absl::StatusOr<std::vector<Journal::Key>> Renew(const std::string&) override {
    return std::vector<Journal::Key>();
  }
  absl::Status GiveUp() override { return absl::OkStatus(); }
  absl::StatusOr<std::vector<std::string>> LiveNodes() override { return nodes_; }
  absl::StatusOr<Located> Locate(const std::string&) override {
    ++looked_;
    if (silent_ != nullptr) silent_->wait();
    const std::lock_guard lock(mutex_);
    const absl::StatusOr<Located> next = answers_.front();
    if (answers_.size() > 1) answers_.pop_front();
    return next;
  }
  absl::StatusOr<std::vector<Located>> LocateAll(const std::string&, std::size_t) override {
    return std::vector<Located>();
  }
  std::int64_t EpochOf(Journal::Key) override { return 1; }
  absl::StatusOr<std::vector<Tail>> ReadTails(const std::vector<Position>&) override {
    return std::vector<Tail>();
  }
  absl::Status AskToFollow(const std::vector<Wish>&) override { return absl::OkStatus(); }
  absl::StatusOr<std::vector<std::string>> AskedToFollow() override {
    return std::vector<std::string>();
  }
  absl::Status SetFollows(Journal::Key, bool) override { return absl::OkStatus(); }
  absl::StatusOr<std::int64_t> HandOver(Journal::Key, const std::string&) override { return 2; }

  absl::Duration lease_ = absl::Hours(1);
  std::vector<std::string> nodes_ = {"here:1", "there:1"};
  std::mutex mutex_;
  std::deque<absl::StatusOr<Located>> answers_;
  std::atomic<int> looked_{0};
  std::shared_future<void>* silent_ = nullptr;  // answers after it
};

class MeshOpenerTest : public ::testing::Test {
 protected:
  MeshOpenerTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }

  static Located Held(absl::Duration left) {
    Located located;
    located.address = "other:1";
    located.epoch = 7;
    located.left = left;
    return located;
  }
  static Located Free() { return Held(absl::ZeroDuration()); }
  static Asking Follows(int redirects) {
    Asking asking;
    asking.redirects = redirects;
    return asking;
  }

  MeshOpener& Opener() {
    if (opener_ == nullptr) {
      opener_ =
          std::make_unique<MeshOpener>(&journal_, "here:1", [this](const Journal::Mesh&) -> Result {
            ++loads_;
            if (hold_ != nullptr) hold_->get_future().wait();
            const std::lock_guard lock(journal_.mutex_);
            const absl::Status next = loaded_.empty() ? absl::OkStatus() : loaded_.front();
            if (!loaded_.empty()) loaded_.pop_front();
            return next.ok() ? Result(MeshOpener::HostPtr()) : Result(next);
          });
    }
    return *opener_;
  }
  Result Open(const Asking& asking = {}, const std::string& id = "m") {
    std::promise<Result> done;
    Opener().Open(id, asking, [&done](Result r) { done.set_value(std::move(r)); });
    return test::WaitFor("the mesh", done);
  }
  // "NOT_OWNER other:1 7"
  static std::string Text(const Result& result) {
    if (result.ok()) return "open";
    const auto error = codec::GetServiceError(result.status());
    if (!error.has_value()) return absl::StatusCodeToString(result.status().code());
    const auto get = [&](const char* key) {
      const auto it = error->metadata.find(key);
      return it == error->metadata.end() ? "" : " " + it->second;
    };
    return error->reason + get("owner") + get("epoch");
  }
  // A mesh that placement gives to the other node.
  std::string PlacedThere() const {
    for (int i = 0;; ++i) {
      const std::string id = "m" + std::to_string(i);
      if (journal_.nodes_[*ChooseNode(journal_.nodes_, id)] == "there:1") return id;
    }
  }

  ScriptedJournal journal_;
  std::atomic<int> loads_{0};
  std::deque<absl::Status> loaded_;  // of the loads, in turn; then OK
  std::promise<void>* hold_ = nullptr;
  std::unique_ptr<MeshOpener> opener_;
};

TEST_F(MeshOpenerTest, AMeshThatDoesNotExistIsNotFound) {
  journal_.answers_ = {NoSuchMesh()};
  EXPECT_EQ(Text(Open()), "MESH_NOT_FOUND");
}

TEST_F(MeshOpenerTest, ADatabaseThatDoesNotAnswerIsToldAndMayBeAskedAgain) {
  journal_.answers_ = {absl::UnavailableError("no connection")};
  const Result failed = Open();
  EXPECT_EQ(Text(failed), "JOURNAL_FAILED");
  EXPECT_TRUE(codec::GetServiceError(failed.status())->retry_after.has_value());
}

TEST_F(MeshOpenerTest, ADatabaseThatDoesNotAnswerIsToldToAllThatWait) {
  journal_.answers_ = {absl::UnavailableError("no connection")};
  std::promise<void> answers;
  std::shared_future<void> silent = answers.get_future().share();
  journal_.silent_ = &silent;
  constexpr int kMeshes = 40;  // more than threads
  std::deque<std::promise<Result>> done(kMeshes);
  for (int i = 0; i < kMeshes; ++i) {
    Opener().Open("m" + std::to_string(i), {},
                  [&one = done[i]](Result r) { one.set_value(std::move(r)); });
  }
  test::WaitUntil("a look", [&] { return journal_.looked_ > 0; });
  answers.set_value();
  for (std::promise<Result>& one : done) {
    const Result failed = test::WaitFor("the mesh", one);
    EXPECT_EQ(Text(failed), "JOURNAL_FAILED");
  }
  // Those under way at that time, not one for each mesh.
  EXPECT_LE(journal_.looked_, 2 * 4);
  journal_.answers_ = {NoSuchMesh()};
  EXPECT_EQ(Text(Open()), "MESH_NOT_FOUND");  // asked again
}

TEST_F(MeshOpenerTest, AnOwnerThatRenewsIsNamed) {
  journal_.answers_ = {Held(absl::Minutes(50))};
  EXPECT_EQ(Text(Open()), "NOT_OWNER other:1 7");
  EXPECT_EQ(Text(Open(Follows(5))), "NOT_OWNER other:1 7");
  EXPECT_EQ(loads_, 0);
}

TEST_F(MeshOpenerTest, AFreeMeshIsOpenedWhereItIsPlacedUnlessTheClientDoesNotGo) {
  const std::string id = PlacedThere();
  journal_.answers_ = {Free()};
  EXPECT_EQ(Text(Open(Follows(0), id)), "NOT_OWNER there:1 7");
  EXPECT_EQ(Text(Open(Follows(1), id)), "NOT_OWNER there:1 7");
  EXPECT_EQ(loads_, 0);
  EXPECT_EQ(Text(Open(Follows(2), id)), "open");
  EXPECT_EQ(Text(Open({}, id)), "open");
  EXPECT_EQ(loads_, 2);
  journal_.nodes_ = {"here:1"};
  EXPECT_EQ(Text(Open(Follows(0), id)), "open");
  Located mine = Held(absl::Hours(1));
  mine.is_mine = true;
  journal_.nodes_ = {"there:1"};
  journal_.answers_ = {mine};
  EXPECT_EQ(Text(Open(Follows(0), id)), "open") << "it has it, by the database";
}

TEST_F(MeshOpenerTest, AnOwnerThatMissedARenewalIsWaitedFor) {
  journal_.lease_ = absl::Milliseconds(50);
  journal_.answers_ = {Held(absl::Milliseconds(10)), Held(absl::Milliseconds(1)), Free()};
  journal_.nodes_ = {"here:1"};
  EXPECT_EQ(Text(Open(Follows(0))), "open");
  EXPECT_EQ(journal_.looked_, 3);
  journal_.answers_ = {Held(absl::Milliseconds(10)), Held(absl::Milliseconds(50))};
  EXPECT_EQ(Text(Open(Follows(0))), "NOT_OWNER other:1 7") << "it renewed";
}

TEST_F(MeshOpenerTest, AClaimThatAnotherNodeWasGrantedLeadsThere) {
  journal_.nodes_ = {"here:1"};
  journal_.answers_ = {Free(), Held(absl::Hours(1))};
  loaded_ = {absl::AbortedError("lost")};
  EXPECT_EQ(Text(Open()), "NOT_OWNER other:1 7");
  // Each time free, and each time lost: it ends.
  journal_.answers_ = {Free()};
  loaded_.assign(100, absl::AbortedError("lost"));
  EXPECT_EQ(Text(Open()), "NOT_OWNER");
  EXPECT_LT(loads_, 10);
}

TEST_F(MeshOpenerTest, AllCallsOfAMeshShareOneLoadAndNoneWaitsBeyondItsDeadline) {
  journal_.nodes_ = {"here:1"};
  journal_.answers_ = {Free()};
  std::promise<void> hold;
  hold_ = &hold;
  constexpr int kCalls = 20;
  std::vector<std::promise<Result>> done(kCalls);
  Opener().Open("m", {}, [&](Result r) { done[0].set_value(std::move(r)); });
  test::WaitUntil("the load", [this] { return loads_ == 1; });
  for (int i = 1; i < kCalls; ++i) {
    Opener().Open("m", {}, [&, i](Result r) { done[i].set_value(std::move(r)); });
  }
  Asking late;
  late.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(1);
  EXPECT_EQ(Text(Open(late)), "DEADLINE_EXCEEDED");
  hold.set_value();
  for (auto& call : done) EXPECT_EQ(Text(test::WaitFor("a call", call)), "open");
  EXPECT_EQ(loads_, 1);
}

TEST_F(MeshOpenerTest, ItsEndAnswersAllThatWait) {
  journal_.lease_ = absl::Hours(1);
  journal_.answers_ = {Held(absl::Minutes(10))};
  std::promise<Result> waits;
  Opener().Open("m", {}, [&](Result r) { waits.set_value(std::move(r)); });
  opener_->Close(absl::CancelledError("the end"));
  EXPECT_TRUE(absl::IsCancelled(test::WaitFor("the call", waits).status()));
  EXPECT_TRUE(absl::IsCancelled(Open().status()));
  opener_->Stop();
  EXPECT_TRUE(absl::IsCancelled(Open().status()));
}

TEST_F(MeshOpenerTest, AFreeMeshGoesToANodeThatFollowsIt) {
  Located located = Free();
  located.followers = {"third:1"};
  journal_.nodes_ = {"here:1", "third:1"};
  journal_.answers_ = {located};
  for (const char* id : {"m", "n", "o"}) {
    EXPECT_EQ(Text(Open(Follows(0), id)), "NOT_OWNER third:1 7") << "wherever it is placed";
  }
  EXPECT_EQ(loads_, 0);
  // A call that stays here waits until that node has claimed it.
  journal_.answers_ = {located, located, Held(absl::Hours(1))};
  EXPECT_EQ(Text(Open()), "NOT_OWNER other:1 7");
  EXPECT_EQ(loads_, 0);
  // But not for ever.
  journal_.answers_ = {located};
  EXPECT_EQ(Text(Open()), "open");
  EXPECT_EQ(loads_, 1);
  located.followers = {"here:1", "third:1"};
  journal_.answers_ = {located};
  const int looked = journal_.looked_;
  EXPECT_EQ(Text(Open()), "open");
  EXPECT_EQ(journal_.looked_, looked + 1) << "at once: it follows the mesh itself";
}

}  // namespace
}  // namespace dynmesh::server::mesh_opener_test
