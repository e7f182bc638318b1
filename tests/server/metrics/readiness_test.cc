// Is a server ready? From recovery to drain, and while its journal fails.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "proto/codec/grpc_status.h"
#include "tests/server/metrics/observe_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::readiness_test {
namespace {

using ReadinessTest = ObserveTest;

// A journal without meshes that is slow to list them.
class SlowJournal final : public Journal {
 public:
  explicit SlowJournal(Mailbox<int>* asked, Mailbox<int>* answer)
      : asked_(asked), answer_(answer) {}
  std::string name() const override { return "slow"; }
  absl::StatusOr<std::vector<Mesh>> List() override {
    asked_->Put(0);
    if (answer_->Take() != 0) return absl::DataLossError("nothing can be read");
    return std::vector<Mesh>();
  }
  absl::StatusOr<Key> Create(const std::string&, const std::string&) override { return Key{1}; }
  absl::Status Delete(Key) override { return absl::OkStatus(); }
  bool Sweep(Key) override { return false; }
  absl::Status Append(Key, const std::vector<Entry>&, const std::vector<Request>&) override {
    return failing_ ? absl::UnavailableError("the disk is full") : absl::OkStatus();
  }
  Counts counts() const override {
    Counts counts;
    counts.failing = failing_;
    return counts;
  }
  absl::Status Read(Key, const Visitor&) override { return absl::OkStatus(); }
  absl::Status ReadPast(Key, std::uint64_t, std::uint64_t, const Visitor&) override {
    return absl::OkStatus();
  }
  absl::StatusOr<std::uint64_t> Oldest(Key) override { return 0; }
  using Journal::Compact;
  absl::Status Compact(Key, std::uint64_t, const std::vector<std::string>&,
                       const std::atomic<bool>&) override {
    return absl::OkStatus();
  }

  void SetFailing(bool failing) { failing_ = failing; }

 private:
  Mailbox<int>* const asked_;
  Mailbox<int>* const answer_;
  std::atomic<bool> failing_{false};
};

TEST_F(ReadinessTest, AServerIsReadyFromTheEndOfRecoveryToTheDrain) {
  ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.metrics = "127.0.0.1:0";
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  Mailbox<int> asked, answer;
  Mailbox<absl::StatusOr<std::unique_ptr<Server>>> started;
  std::thread starter([&] {
    started.Put(Server::Start(
        config,
        [gate = gate_](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o, gate); },
        std::make_unique<SlowJournal>(&asked, &answer)));
  });
  asked.Take();
  metrics_ = MetricsAddress(testing::internal::GetCapturedStderr());
  ASSERT_TRUE(SetLogLevel("error").ok());
  EXPECT_EQ(HttpGet(metrics_, "/healthz").status, 200);
  HttpAnswer ready = HttpGet(metrics_, "/readyz");
  EXPECT_EQ(ready.status, 503);
  EXPECT_EQ(ready.body, "recovering\n");
  EXPECT_EQ(Scrape().Value("dynmesh_meshes"), 0);

  answer.Put(0);
  server_ = *started.Take();
  starter.join();
  EXPECT_EQ(HttpGet(metrics_, "/readyz").status, 200);

  // An edit under way keeps the drain from ending.
  client_ = client::MeshClient::Connect(server_->address());
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  gate_->Hold();
  std::thread editor([&] { EXPECT_TRUE(client_->Apply("m", {AddPoint(1)}).ok()); });
  gate_->WaitForArrivals(1);
  std::thread drainer([&] { EXPECT_TRUE(server_->Drain(kLong)); });
  test::WaitUntil("the drain",
                  [&] { return (ready = HttpGet(metrics_, "/readyz")).status != 200; });
  EXPECT_EQ(ready.status, 503);
  EXPECT_EQ(ready.body, "draining\n");
  EXPECT_EQ(HttpGet(metrics_, "/healthz").status, 200);
  gate_->Release();
  editor.join();
  drainer.join();
  server_.reset();
  EXPECT_EQ(HttpGet(metrics_, "/healthz").status, 0);
}

class RecoveringTest : public ObserveTest {
 protected:
  RecoveringTest() {
    EXPECT_TRUE(SetLogLevel("info").ok());
    testing::internal::CaptureStderr();
    ServerConfig config;
    config.listen = "127.0.0.1:0";
    starter_ = std::thread([this, config] {
      started_.Put(Server::Start(
          config,
          [gate = gate_](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o, gate); },
          std::make_unique<SlowJournal>(&asked_, &answer_)));
    });
    asked_.Take();
    address_ = AddressIn(testing::internal::GetCapturedStderr(), "listening");
    EXPECT_TRUE(SetLogLevel("off").ok());
  }
  ~RecoveringTest() override { starter_.join(); }

  Mailbox<int> asked_, answer_;
  Mailbox<absl::StatusOr<std::unique_ptr<Server>>> started_;
  std::thread starter_;
};

TEST_F(RecoveringTest, CallsAreToldToComeAgainAndGetThroughAfterwards) {
  ASSERT_NE(address_, "");
  const auto client = client::MeshClient::Connect(address_);
  const std::vector<Feature> points = {AddPoint(1).feature};
  for (const absl::Status& status :
       {client->GetStats().status(), client->CreateMesh("m", MeshOptions()).status(),
        client->ListMeshes().status(), client->Apply("m", {AddPoint(1)}).status(),
        client->Load("m", points).status(), client->GetSnapshot("m").status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << Text(status);
    EXPECT_EQ(ReasonOf(status), codec::reason::kRecovering) << Text(status);
    EXPECT_TRUE(codec::GetServiceError(status)->retry_after.has_value());
  }
  client::WatchOptions patient;
  patient.max_attempts = 1'000'000;
  patient.longest_pause = absl::Milliseconds(20);
  const auto watch = client->Watch("late", patient, nullptr);
  EXPECT_EQ(Health(""), 2);
  EXPECT_EQ(Health("dynmesh.v1.MeshService"), 2);

  answer_.Put(0);
  server_ = *started_.Take();
  // Over the same connection, without a pause.
  ASSERT_TRUE(client->CreateMesh("m", MeshOptions()).ok());
  EXPECT_TRUE(client->Apply("m", {AddPoint(1)}).ok());
  EXPECT_EQ(Health(""), 1);
  EXPECT_EQ(Health("dynmesh.v1.MeshService"), 1);
  // A watch retries until it gets the answer: there is no such mesh.
  EXPECT_TRUE(Eventually([&] { return watch->ended().has_value(); }));
  EXPECT_EQ(ReasonOf(*watch->ended()), codec::reason::kMeshNotFound);
}

TEST_F(RecoveringTest, AJournalThatCannotBeReadClosesThePortAgain) {
  const auto client = client::MeshClient::Connect(address_);
  EXPECT_EQ(ReasonOf(client->GetStats().status()), codec::reason::kRecovering);
  answer_.Put(1);
  EXPECT_EQ(started_.Take().status().code(), absl::StatusCode::kDataLoss);
  const absl::Status gone = client->GetStats().status();
  EXPECT_EQ(gone.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(ReasonOf(gone), "");
}

// Otherwise no edit would test whether the journal can be written again.
TEST_F(ReadinessTest, AServerIsReadyThoughItsJournalFailsAndSaysSo) {
  Mailbox<int> asked, answer;
  answer.Put(0);
  auto journal = std::make_unique<SlowJournal>(&asked, &answer);
  SlowJournal& disk = *journal;
  ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.metrics = "127.0.0.1:0";
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  server_ = *Server::Start(
      config,
      [gate = gate_](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o, gate); },
      std::move(journal));
  metrics_ = MetricsAddress(testing::internal::GetCapturedStderr());
  ASSERT_TRUE(SetLogLevel("off").ok());
  client_ = client::MeshClient::Connect(server_->address());
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  EXPECT_EQ(HttpGet(metrics_, "/readyz").body, "ready\n");
  disk.SetFailing(true);
  EXPECT_EQ(ReasonOf(client_->Apply("m", {AddPoint(1)}).status()), codec::reason::kJournalFailed);
  const HttpAnswer failing = HttpGet(metrics_, "/readyz");
  EXPECT_EQ(failing.status, 200);
  EXPECT_EQ(failing.body, "ready; edits are refused: the journal cannot be written\n");
  EXPECT_EQ(Health(""), 1);
  EXPECT_TRUE(client_->GetSnapshot("m").ok());
  disk.SetFailing(false);
  EXPECT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  EXPECT_EQ(HttpGet(metrics_, "/readyz").body, "ready\n");
}

TEST_F(ReadinessTest, AMetricsPortThatIsTakenIsAnErrorAtTheStart) {
  StartObserved();
  ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.metrics = metrics_;
  const auto factory = [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); };
  EXPECT_EQ(Server::Start(config, factory).status().code(), absl::StatusCode::kUnavailable);
  config.metrics = "nonsense";
  EXPECT_EQ(Server::Start(config, factory).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dynmesh::server::readiness_test
