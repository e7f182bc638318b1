// A server whose disk hangs in a sync: what it says, and what it does at the end.
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/journal/sqlite_journal.h"
#include "server/journal_watch.h"
#include "tests/server/journal/failing_vfs.h"
#include "tests/server/metrics/observe_fixture.h"
#include "tests/support/deadline.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::hanging_journal_test {
namespace {

class HangingJournalTest : public ObserveTest {
 protected:
  ~HangingJournalTest() override {
    FailingVfs::Heal();
    server_.reset();
  }

  void Start() {
    SqliteJournal::Options options;
    options.vfs = FailingVfs::Name();
    auto journal = SqliteJournal::Open(folder_.path(), options);
    ASSERT_TRUE(journal.ok()) << journal.status();
    journal_ = journal->get();
    ServerConfig config;
    config.listen = config.metrics = "127.0.0.1:0";
    ASSERT_TRUE(SetLogLevel("info").ok());
    testing::internal::CaptureStderr();
    auto server = Server::Start(
        config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); },
        *std::move(journal));
    metrics_ = MetricsAddress(testing::internal::GetCapturedStderr());
    ASSERT_TRUE(SetLogLevel("off").ok());
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    client_ = client::MeshClient::Connect(server_->address());
  }

  test::TempFolder folder_;
  Journal* journal_ = nullptr;
};

// One batch is in the sync; of the others none may be handed to the disk after the drain's limit.
TEST_F(HangingJournalTest, AfterTheDrainsLimitOnlyTheSyncUnderWayIsWaitedFor) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  ASSERT_TRUE(client_->CreateMesh("n", MeshOptions()).ok());
  FailingVfs::HoldSyncs();
  std::vector<std::thread> editors;
  Mailbox<absl::Status> first, others;
  editors.emplace_back([&] { first.Put(client_->Apply("m", {AddPoint(1)}).status()); });
  test::WaitUntil("the sync", [] { return FailingVfs::held() == 1; });
  for (FeatureId id = 2; id <= 4; ++id) {
    for (const char* mesh : {"m", "n"}) {
      editors.emplace_back([&, id, mesh] {
        others.Put(client_->Apply(mesh, {AddPoint(id)}, Id(absl::StrCat(mesh, id))).status());
      });
    }
  }
  editors.emplace_back([&] { others.Put(client_->CreateMesh("o", MeshOptions()).status()); });
  test::WaitUntil("the others", [this] {
    return Host("meshes/m")->running().has_value() && Host("meshes/n")->running().has_value();
  });
  Mailbox<bool> drained;
  std::thread drainer([&] { drained.Put(server_->Drain(absl::Milliseconds(100))); });
  for (int i = 0; i < 7; ++i) {
    const absl::Status status = others.Take();
    EXPECT_FALSE(status.ok());
  }
  EXPECT_EQ(FailingVfs::held(), 1);
  EXPECT_EQ(drained.size(), 0u);
  FailingVfs::Heal();
  EXPECT_FALSE(drained.Take());
  (void)first.Take();  // its call may have been cut off
  drainer.join();
  for (std::thread& editor : editors) editor.join();
  server_.reset();
  // Of the batches only the first was written: what it was acknowledged as or not.
  auto journal = SqliteJournal::Open(folder_.path(), {});
  ASSERT_TRUE(journal.ok()) << journal.status();
  std::string found;
  const std::vector<Journal::Mesh> meshes = *(*journal)->List();
  for (const Journal::Mesh& mesh : meshes) {
    absl::StrAppend(&found, mesh.id, ":", mesh.entries, " ");
  }
  EXPECT_EQ(found, "m:1 n:0 ");
}

TEST_F(HangingJournalTest, TheAgeOfTheOldestWriteIsAMetric) {
  Start();
  EXPECT_EQ(Scrape().Value("dynmesh_journal_oldest_write_seconds"), 0);
  EXPECT_EQ(Scrape().Value("dynmesh_journal_gone"), 0);
  FailingVfs::HoldSyncs();
  std::thread maker([&] { EXPECT_TRUE(client_->CreateMesh("m", MeshOptions()).ok()); });
  double age = 0;
  test::WaitUntil("an old write", [&] {
    const double now = Scrape().Value("dynmesh_journal_oldest_write_seconds");
    EXPECT_GE(now, age);
    age = now;
    return age > 0.2;
  });
  FailingVfs::Heal();
  maker.join();
  EXPECT_EQ(Scrape().Value("dynmesh_journal_oldest_write_seconds"), 0);
}

TEST_F(HangingJournalTest, AFolderThatIsGoneIsSaidByReadinessAndMetrics) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  const std::string moved = folder_.path() + "-moved";
  std::filesystem::rename(folder_.path(), moved);
  const absl::Status refused = client_->Apply("m", {AddPoint(2)}).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kUnavailable) << refused;
  EXPECT_EQ(ReasonOf(refused), codec::reason::kJournalFailed) << refused;
  EXPECT_EQ(Scrape().Value("dynmesh_journal_gone"), 1);
  EXPECT_EQ(Scrape().Value("dynmesh_journal_failing"), 1);
  const HttpAnswer ready = HttpGet(metrics_, "/readyz");
  EXPECT_EQ(ready.status, 200);
  EXPECT_EQ(ready.body,
            "ready; edits are refused: the data folder is not the one that was opened\n");
  EXPECT_TRUE(client_->GetSnapshot("m").ok());
  std::filesystem::rename(moved, folder_.path());
  EXPECT_TRUE(client_->Apply("m", {AddPoint(2)}).ok());
  EXPECT_EQ(HttpGet(metrics_, "/readyz").body, "ready\n");
  EXPECT_EQ(HeadOf().revision, 2u);
}

// A journal in a state that the test gives it.
class StatedJournal final : public Journal {
 public:
  std::string name() const override { return "stated"; }
  Counts counts() const override { return state; }
  absl::StatusOr<std::vector<Mesh>> List() override { return std::vector<Mesh>(); }
  absl::StatusOr<Key> Create(const std::string&, const std::string&) override { return Key{1}; }
  absl::Status Delete(Key) override { return absl::OkStatus(); }
  bool Sweep(Key) override { return false; }
  absl::Status Append(Key, const std::vector<Entry>&, const std::vector<Request>&) override {
    return absl::OkStatus();
  }
  absl::Status Read(Key, const Visitor&) override { return absl::OkStatus(); }
  absl::Status ReadPast(Key, std::uint64_t, std::uint64_t, const Visitor&) override {
    return absl::OkStatus();
  }
  absl::StatusOr<std::uint64_t> Oldest(Key) override { return 0; }
  absl::Status Compact(Key, std::uint64_t, const std::vector<std::string>&,
                       const std::atomic<bool>&) override {
    return absl::OkStatus();
  }

  Counts state;
};

TEST(JournalWatchTest, AWriteThatHangsIsToldOnceAndSoIsItsEnd) {
  StatedJournal journal;
  JournalWatch watch(&journal);
  ASSERT_TRUE(SetLogLevel("info").ok());
  const auto look = [&](absl::Duration oldest) {
    journal.state.oldest_write = oldest;
    testing::internal::CaptureStderr();
    watch.Look();
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(look(JournalWatch::kHangs), "");
  EXPECT_EQ(watch.Amiss(), "");
  const std::string hangs = look(JournalWatch::kHangs + absl::Seconds(2));
  EXPECT_TRUE(absl::StrContains(hangs, "level=warning event=journal_hangs")) << hangs;
  EXPECT_TRUE(absl::StrContains(hangs, "seconds=7")) << hangs;
  EXPECT_EQ(watch.Amiss(), "edits wait: the journal has not answered a write for 7 s");
  EXPECT_EQ(look(absl::Seconds(40)), "");
  const std::string answers = look(absl::ZeroDuration());
  EXPECT_TRUE(absl::StrContains(answers, "event=journal_answers_again")) << answers;
  EXPECT_TRUE(absl::StrContains(answers, "longest_seconds=40")) << answers;
  EXPECT_EQ(look(absl::ZeroDuration()), "");
  EXPECT_TRUE(absl::StrContains(look(absl::Seconds(6)), "journal_hangs"));
  // What is worse is said first.
  journal.state.failing = true;
  EXPECT_EQ(watch.Amiss(), "edits are refused: the journal cannot be written");
  journal.state.gone = true;
  EXPECT_EQ(watch.Amiss(), "edits are refused: the data folder is not the one that was opened");
  ASSERT_TRUE(SetLogLevel("off").ok());
  EXPECT_EQ(JournalWatch(nullptr).Amiss(), "");
}

}  // namespace
}  // namespace dynmesh::server::hanging_journal_test
