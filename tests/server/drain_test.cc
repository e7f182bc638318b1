// The end of a server: in order, with a short limit, abrupt.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"
#include "tests/support/raw_http2.h"

namespace dynmesh::server::drain_test {
namespace {

using DrainTest = ServerFixture;
using absl::StatusCode;

TEST_F(DrainTest, ADrainEndsWhatRunsAndRefusesWhatIsNew) {
  StartWithMesh();
  const auto watch = client_->Watch("m", {.max_attempts = 0}, nullptr);
  ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
  const auto stream = client_->OpenEdits("m");
  ASSERT_TRUE(stream->Send({AddPoint(10)}, Id("s1")).ok());
  ASSERT_TRUE(stream->Receive()->result.ok());

  gate_->Hold();
  Mailbox<absl::StatusOr<client::EditResult>> running;
  std::thread editor([&] { running.Put(client_->Apply("m", {AddPoint(1)})); });
  gate_->WaitForArrivals(2);
  ASSERT_TRUE(stream->Send({AddPoint(11)}, Id("s2")).ok());
  test::WaitUntil("the batch of the stream", [&] { return Host()->waiting() >= 1; });

  Mailbox<bool> drained;
  std::thread drainer([&] { drained.Put(server_->Drain(kLong)); });
  test::WaitUntil("the drain", [&] { return Health("") == 2; });
  EXPECT_EQ(Health("dynmesh.v1.MeshService"), 2);
  EXPECT_FALSE(watch->WaitForRevision(99, kLong));
  EXPECT_EQ(ReasonOf(*watch->ended()), codec::reason::kDraining);
  // The gate closes a moment after the health says so.
  absl::Status refused;
  test::WaitUntil("a refusal", [&] {
    refused = client_->CreateMesh("", {}).status();
    return !refused.ok();
  });
  EXPECT_EQ(refused.code(), StatusCode::kUnavailable);
  EXPECT_EQ(ReasonOf(refused), codec::reason::kDraining);
  EXPECT_TRUE(codec::GetServiceError(refused)->retry_after.has_value());
  EXPECT_EQ(ReasonOf(client_->Apply("m", {AddPoint(2)}).status()), codec::reason::kDraining);

  gate_->Release();
  const auto result = running.Take();
  ASSERT_TRUE(result.ok()) << Text(result.status());
  EXPECT_EQ(result->diff.to_revision, 2u);
  // The submitted batches of the stream are answered, then the stream ends.
  const auto answer = stream->Receive();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->request_id, "s2");
  EXPECT_TRUE(answer->result.ok());
  EXPECT_FALSE(stream->Receive().has_value());
  EXPECT_EQ(ReasonOf(stream->Finish()), codec::reason::kDraining);
  EXPECT_TRUE(drained.Take());
  editor.join();
  drainer.join();
}

TEST_F(DrainTest, ADrainThatTakesTooLongCancels) {
  StartWithMesh();
  gate_->Hold();
  const auto host = Host();
  Mailbox<absl::StatusOr<client::EditResult>> running;
  std::thread editor([&] { running.Put(client_->Apply("m", {AddPoint(1)})); });
  gate_->WaitForArrivals(1);
  EXPECT_FALSE(server_->Drain(absl::Milliseconds(20)));
  const auto result = running.Take();
  EXPECT_EQ(ReasonOf(result.status()), codec::reason::kDraining) << Text(result.status());
  EXPECT_EQ(host->head().revision, 0u);
  editor.join();
}

TEST_F(DrainTest, ADrainThatTakesTooLongCancelsTheBatchesOfAStream) {
  StartWithMesh();
  gate_->Hold();
  const auto host = Host();
  const auto stream = client_->OpenEdits("m");
  ASSERT_TRUE(stream->Send({AddPoint(1)}, Id("s1")).ok());
  ASSERT_TRUE(stream->Send({AddPoint(2)}, Id("s2")).ok());
  gate_->WaitForArrivals(1);
  test::WaitUntil("the second batch", [&] { return host->waiting() >= 1; });
  EXPECT_FALSE(server_->Drain(absl::Milliseconds(20)));
  for (const char* const id : {"s1", "s2"}) {
    const auto answer = stream->Receive();
    ASSERT_TRUE(answer.has_value()) << Text(stream->Finish());
    EXPECT_EQ(answer->request_id, id);
    EXPECT_EQ(ReasonOf(answer->result.status()), codec::reason::kDraining)
        << Text(answer->result.status());
  }
  EXPECT_FALSE(stream->Receive().has_value());
  EXPECT_EQ(ReasonOf(stream->Finish()), codec::reason::kDraining);
  EXPECT_EQ(host->head().revision, 0u);
}

TEST_F(DrainTest, ADrainThatTakesTooLongCancelsALoad) {
  StartWithMesh();
  gate_->Hold();
  const auto host = Host();
  Mailbox<absl::StatusOr<client::LoadResult>> running;
  std::thread loader([&] { running.Put(client_->Load("m", std::vector{AddPoint(1).feature})); });
  gate_->WaitForArrivals(1);
  EXPECT_FALSE(server_->Drain(absl::Milliseconds(20)));
  const auto result = running.Take();
  EXPECT_EQ(ReasonOf(result.status()), codec::reason::kDraining) << Text(result.status());
  EXPECT_EQ(host->head().revision, 0u);
  loader.join();
}

// The mesh takes longer to undo its batch than the drain waits.
TEST_F(DrainTest, CallsThatADrainCutsNameTheReason) {
  StartWithMesh();
  gate_->Hold();
  gate_->HoldCancelled();
  Mailbox<absl::StatusOr<client::LoadResult>> loading;
  std::thread loader([&] { loading.Put(client_->Load("m", std::vector{AddPoint(1).feature})); });
  gate_->WaitForArrivals(1);
  Mailbox<absl::StatusOr<client::EditResult>> applying;
  std::thread editor([&] { applying.Put(client_->Apply("m", {AddPoint(2)})); });
  test::WaitUntil("the edit", [&] { return Host()->waiting() >= 1; });
  Mailbox<bool> drained;
  std::thread drainer([&] { drained.Put(server_->Drain(absl::Milliseconds(20))); });
  const absl::Status loaded = loading.Take().status();
  const absl::Status applied = applying.Take().status();
  gate_->Release();
  EXPECT_FALSE(drained.Take());
  EXPECT_EQ(loaded.code(), StatusCode::kUnavailable) << Text(loaded);
  EXPECT_NE(Text(loaded).find("DRAINING: the server ended before it answered"), std::string::npos)
      << Text(loaded);
  // It was waiting: nothing is to be undone.
  EXPECT_EQ(ReasonOf(applied), codec::reason::kDraining) << Text(applied);
  for (std::thread* thread : {&loader, &editor, &drainer}) thread->join();
}

// One after the other on one connection: each is applied, or refused for the drain.
TEST_F(DrainTest, EditsThatComeDuringADrainGetItsReason) {
  for (int round = 0; round < 5; ++round) {
    StartWithMesh();
    std::vector<std::thread> editors;
    std::atomic<int> applied{0};
    for (FeatureId first : {1, 1000, 2000, 3000}) {
      editors.emplace_back([&, first] {
        const auto client = client::MeshClient::Connect(server_->address());
        absl::Status status;
        for (FeatureId id = first; status.ok(); ++id) {
          status = client->Apply("m", {AddPoint(id)}).status();
          if (status.ok()) ++applied;
        }
        EXPECT_EQ(ReasonOf(status), codec::reason::kDraining) << Text(status);
      });
    }
    test::WaitUntil("edits", [&] { return applied > 20; });
    EXPECT_TRUE(server_->Drain(kLong));
    for (std::thread& editor : editors) editor.join();
  }
}

// It answers nothing, like a client's connection without a call. gRPC would wait for an answer to
// its ping until the calls' five seconds are over.
TEST_F(DrainTest, AConnectionWithoutCallsIsToldToGoAndDoesNotHoldTheDrain) {
  // 0.05 s each, on a machine that is idle. Of several one has to be quick: where the wait is part
  // of the drain, none is.
  absl::Duration best = absl::InfiniteDuration();
  for (int i = 0; i < 10 && best > absl::Seconds(4); ++i) {
    StartWithMesh();
    test::RawConnection silent(server_->port());
    ASSERT_TRUE(silent.connected() && silent.Greet());
    ASSERT_TRUE(silent.WaitForBytes(30'000));  // it is a connection of the server's now
    const absl::Time start = absl::Now();
    EXPECT_TRUE(server_->Drain(kLong));
    best = std::min(best, absl::Now() - start);
    std::string frames;
    EXPECT_TRUE(silent.ReadFrameTypes(0, &frames));
    EXPECT_NE(frames.find('\x07'), std::string::npos) << "no GOAWAY";
  }
  EXPECT_LT(best, absl::Seconds(4));
}

TEST_F(DrainTest, AServerEndsWithAllKindsOfStreamsOpen) {
  StartWithMesh();
  std::vector<std::unique_ptr<client::WatchSession>> watches;
  std::vector<std::unique_ptr<client::EditSession>> streams;
  for (int i = 0; i < 10; ++i) {
    watches.push_back(client_->Watch("m", {}, nullptr));
    streams.push_back(client_->OpenEdits("m"));
    ASSERT_TRUE(streams.back()->Send({AddPoint(static_cast<FeatureId>(i) + 1)}).ok());
  }
  server_.reset();
  for (const auto& stream : streams) {
    while (stream->Receive().has_value()) {
    }
    EXPECT_FALSE(stream->Finish().ok());
  }
}

}  // namespace
}  // namespace dynmesh::server::drain_test
