// Calls with a client that reads slowly or not at all, over loopback, with fake meshes far larger
// than gRPC's buffers of a call.
#include <gtest/gtest.h>

#include <algorithm>

#include "absl/strings/match.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "tests/server/server_fixture.h"

namespace dynmesh::server::send_timeout_test {
namespace {

constexpr FeatureId kMany = 100'000;

class SendTimeoutTest : public ServerFixture {
 protected:
  void StartLarge(absl::Duration limit) {
    ServerConfig config;
    config.send_timeout = limit;
    config.max_snapshot_streams = config.max_watchers = config.max_edit_streams = 1;
    StartWithMesh(config);
    EditBatch points;
    for (FeatureId id = 1; id <= kMany; ++id) points.push_back(AddPoint(id));
    client::EditParams params;
    params.omit_columns = true;
    ASSERT_TRUE(client_->Apply("m", points, params).ok());
    // Takes 64 kB ahead of its reader, and does not learn to take more.
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    stub_ = v1::MeshService::NewStub(grpc::CreateCustomChannel(
        server_->address(), grpc::InsecureChannelCredentials(), arguments));
  }
  // Soon: there is one such place.
  void ExpectFreePlace() {
    const auto other = Another();
    EXPECT_TRUE(Eventually([&other] {
      const absl::Status status = other->GetSnapshot("m", std::vector<FeatureId>{77}).status();
      EXPECT_TRUE(status.ok() || ReasonOf(status) == codec::reason::kStreamLimit) << Text(status);
      return status.ok();
    }));
  }
  static void ExpectEnded(const grpc::Status& status) {
    EXPECT_EQ(status.error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
    EXPECT_TRUE(absl::StartsWith(status.error_message(), "SLOW_RECEIVER"))
        << status.error_message();
  }
  // Reads what is still on the way.
  template <typename Reader, typename Message>
  static void ExpectEnds(Reader& reader, Message message) {
    while (reader.Read(&message)) {
    }
    ExpectEnded(reader.Finish());
  }
  // Does not read the stream that `start` opens; `given_up` waits until its lease is free.
  template <typename Message, typename Request, typename Start, typename GivenUp>
  void ExpectEndsUnread(Start start, GivenUp given_up) {
    StartLarge(absl::Milliseconds(300));
    Request request;
    request.set_mesh("meshes/m");
    grpc::ClientContext context;
    const auto reader = start(&context, request);
    reader->WaitForInitialMetadata();  // from here on it has its place
    given_up();
    ExpectEnds(*reader, Message());
  }
  std::unique_ptr<client::MeshClient> Another() const {
    client::ClientOptions options;
    options.own_connection = true;
    return client::MeshClient::Connect(server_->address(), options);
  }
};

TEST_F(SendTimeoutTest, ASnapshotThatNobodyReadsGivesUpItsPlace) {
  ExpectEndsUnread<v1::SnapshotChunk, v1::GetSnapshotRequest>(
      [this](auto... call) { return stub_->GetSnapshot(call...); }, [this] { ExpectFreePlace(); });
}

TEST_F(SendTimeoutTest, FeaturesThatNobodyReadsGiveUpTheirPlace) {
  ExpectEndsUnread<v1::FeaturesChunk, v1::GetFeaturesRequest>(
      [this](auto... call) { return stub_->GetFeatures(call...); }, [this] { ExpectFreePlace(); });
}

TEST_F(SendTimeoutTest, AWatchThatNobodyReadsEnds) {
  ExpectEndsUnread<v1::WatchEvent, v1::WatchRequest>(
      [this](auto... call) { return stub_->Watch(call...); },
      [this] { EXPECT_TRUE(Eventually([&] { return Host()->hub()->size() == 0; })); });
}

TEST_F(SendTimeoutTest, AnswersThatNobodyReadsEndTheirCalls) {
  StartLarge(absl::Milliseconds(300));
  v1::AddFeaturesRequest request;
  request.set_mesh("meshes/m");
  for (FeatureId id = kMany + 1; id <= kMany + 40'000; ++id) {
    codec::EncodeFeature(AddPoint(id).feature, 2, request.add_features());
  }
  grpc::ClientContext context;
  const auto reader = stub_->AddFeatures(&context, request);
  ASSERT_TRUE(Eventually([&] { return HeadOf().revision == 2; }));

  grpc::ClientContext stream_context;
  const auto stream = stub_->EditStream(&stream_context);
  v1::EditBatch batch;
  batch.set_mesh("meshes/m");
  for (FeatureId id = 1; id <= kMany; ++id)
    codec::EncodeEdit(Edit::Remove(id), 2, batch.add_edits());
  ASSERT_TRUE(stream->Write(batch));
  ASSERT_TRUE(Eventually([&] { return HeadOf().revision == 3; }));
  // It had the only place among edit streams.
  const auto other = Another();
  EXPECT_TRUE(Eventually([&] {
    const auto next = other->OpenEdits("m");
    return next->Send({AddPoint(1)}).ok() && next->Receive().has_value();
  }));
  ExpectEnds(*stream, v1::MeshDiff());
  ExpectEnds(*reader, v1::MeshDiff());
  EXPECT_EQ(HeadOf().revision, 4u);
}

TEST_F(SendTimeoutTest, WhoReadsSlowlyGetsAll) {
  constexpr absl::Duration kLimit = absl::Seconds(1);
  StartLarge(kLimit);
  v1::GetSnapshotRequest request;
  request.set_mesh("meshes/m");
  bool steady = false;
  // Repeated if the machine delayed the reader too much.
  for (int i = 0; i < 10 && !steady; ++i) {
    grpc::ClientContext context;
    const auto reader = stub_->GetSnapshot(&context, request);
    v1::SnapshotChunk chunk;
    absl::Time before = absl::Now();
    const absl::Time start = before;
    absl::Duration longest;
    int chunks = 0;
    while (reader->Read(&chunk)) {
      ++chunks;
      absl::SleepFor(kLimit / 4);
      longest = std::max(longest, absl::Now() - before);
      before = absl::Now();
    }
    const grpc::Status status = reader->Finish();
    steady = longest < kLimit / 2;
    if (!steady) continue;
    EXPECT_TRUE(status.ok()) << chunks << " chunks: " << status.error_message();
    EXPECT_GT(before - start, kLimit);
  }
  EXPECT_TRUE(steady);
}

TEST_F(SendTimeoutTest, ZeroIsNever) {
  ServerConfig config;
  config.send_timeout = absl::ZeroDuration();
  EXPECT_TRUE(ValidateConfig(config).ok());
  config.send_timeout = -absl::Seconds(1);
  EXPECT_FALSE(ValidateConfig(config).ok());
  StartLarge(absl::ZeroDuration());
  v1::GetSnapshotRequest request;
  request.set_mesh("meshes/m");
  grpc::ClientContext context;
  const auto reader = stub_->GetSnapshot(&context, request);
  v1::SnapshotChunk chunk;
  ASSERT_TRUE(reader->Read(&chunk));
  absl::SleepFor(absl::Milliseconds(300));  // three ticks
  while (reader->Read(&chunk)) {
  }
  EXPECT_TRUE(reader->Finish().ok());
}

}  // namespace
}  // namespace dynmesh::server::send_timeout_test
