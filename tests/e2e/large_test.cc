// Large meshes and large batches over the network: messages stay small, and a fault in a batch of
// any size is named and changes nothing.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/e2e_fixture.h"

namespace dynmesh::large_test {
namespace {

constexpr std::size_t kMostBytes = 1'000'000;  // of a message
constexpr std::size_t kManyBytes = 256'000;    // the largest of many have at least this
constexpr std::size_t kWatchBytes = 60'000;    // ... of a watch
constexpr std::size_t kEditsOfMessage = 16'384;
#ifdef __SANITIZE_ADDRESS__
constexpr std::size_t kPoints = 20'000;
#else
constexpr std::size_t kPoints = 190'000;  // a mesh of 300,000 vertices
#endif

// Receives streams of messages and measures them.
class LargeMessagesTest : public EndToEndTest {
 protected:
  LargeMessagesTest()
      : stub_(v1::MeshService::NewStub(
            grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()))) {}

  // The next whole diff of a stream, each fragment of which `read` gets into the message.
  MeshDiff ReceiveDiff(const std::function<const v1::MeshDiff*()>& read) {
    codec::DiffAssembler assembler;
    while (const v1::MeshDiff* fragment = read()) {
      EXPECT_EQ(fragment->status().code(), 0) << fragment->status().message();
      const auto diff = assembler.Add(*fragment);
      EXPECT_TRUE(diff.ok()) << diff.status();
      if (!diff.ok()) break;
      if (diff->has_value()) return **diff;
    }
    ADD_FAILURE() << "the stream ended before the diff";
    return {};
  }

  template <typename Message>
  void Measure(const Message& message) {
    const std::size_t bytes = message.ByteSizeLong();
    EXPECT_LE(bytes, kMostBytes);
    largest_ = std::max(largest_, bytes);
  }

  // One batch, in as many messages as it takes.
  MeshDiff Stream(const EditBatch& batch) {
    grpc::ClientContext context;
    const auto stream = stub_->EditStream(&context);
    for (std::size_t next = 0; next < batch.size();) {
      v1::EditBatch message;
      message.set_mesh("meshes/m");
      for (std::size_t i = 0; i < kEditsOfMessage && next < batch.size(); ++i, ++next) {
        codec::EncodeEdit(batch[next], 2, message.add_edits());
      }
      message.set_more(next < batch.size());
      EXPECT_TRUE(stream->Write(message));
    }
    stream->WritesDone();
    v1::MeshDiff message;
    MeshDiff diff = ReceiveDiff([&]() -> const v1::MeshDiff* {
      if (!stream->Read(&message)) return nullptr;
      Measure(message);
      return &message;
    });
    EXPECT_FALSE(stream->Read(&message));
    EXPECT_TRUE(stream->Finish().ok());
    return diff;
  }

  MeshDiff ApplyEdits(const EditBatch& batch) {
    v1::ApplyEditsRequest request;
    request.set_mesh("meshes/m");
    for (const Edit& edit : batch) codec::EncodeEdit(edit, 2, request.add_edits());
    grpc::ClientContext context;
    const auto reader = stub_->ApplyEdits(&context, request);
    v1::MeshDiff message;
    MeshDiff diff = ReceiveDiff([&]() -> const v1::MeshDiff* {
      if (!reader->Read(&message)) return nullptr;
      Measure(message);
      return &message;
    });
    EXPECT_TRUE(reader->Finish().ok());
    return diff;
  }

  std::unique_ptr<v1::MeshService::Stub> stub_;
  std::size_t largest_ = 0;
};

TEST_F(LargeMessagesTest, NoneIsAboveAMegabyte) {
  std::mt19937_64 random(11);
  const MeshDiff filled = Stream(RandomPoints(random, 1, kPoints));
  ASSERT_GE(filled.added_vertices.size(), kPoints * 30 / 19);
  const MeshDiff more = ApplyEdits(RandomPoints(random, 1'000'000, kEditsOfMessage));
  ASSERT_GE(more.added_vertices.size(), kEditsOfMessage);
  EXPECT_GE(largest_, kManyBytes);

  grpc::ClientContext snapshot_context;
  v1::GetSnapshotRequest snapshot_request;
  snapshot_request.set_mesh("meshes/m");
  const auto snapshot = stub_->GetSnapshot(&snapshot_context, snapshot_request);
  codec::SnapshotAssembler assembler;
  std::optional<Mesh> mesh;
  largest_ = 0;
  for (v1::SnapshotChunk chunk; snapshot->Read(&chunk);) {
    Measure(chunk);
    mesh = *assembler.Add(chunk);
  }
  EXPECT_TRUE(snapshot->Finish().ok());
  ASSERT_TRUE(mesh.has_value());
  EXPECT_GE(mesh->vertices.size(), filled.added_vertices.size());
  EXPECT_EQ(ComputeHash(*mesh), HeadOf().hash);
  EXPECT_GE(largest_, kManyBytes);

  // From the start: each revision as it was. Without one: a snapshot, of the base.
  for (const bool from_start : {true, false}) {
    grpc::ClientContext context;
    v1::WatchRequest request;
    request.set_mesh("meshes/m");
    if (from_start) request.set_start_revision(0);
    const auto reader = stub_->Watch(&context, request);
    v1::WatchEvent event;
    std::uint64_t revision = 0;
    largest_ = 0;
    while (revision < HeadOf().revision && reader->Read(&event)) {
      Measure(event);
      if (event.has_diff() && !event.diff().more()) revision = event.diff().to_revision();
      if (event.has_snapshot() && !event.snapshot().more()) revision = event.snapshot().revision();
    }
    EXPECT_EQ(revision, HeadOf().revision);
    EXPECT_GE(largest_, kWatchBytes);
    context.TryCancel();
    reader->Finish();
  }
}

class HugeBatchTest : public EndToEndTest {
 protected:
  // With 64 bytes for an edit, the nightly setting is half of what a server takes.
  std::size_t count() const {
    return std::getenv("DYNMESH_NIGHTLY") != nullptr ? 1'000'000 : 100'000;
  }
};

TEST_F(HugeBatchTest, OneBadEditIsNamedAndNothingChanges) {
  std::mt19937_64 random(12);
  ASSERT_TRUE(client_->Apply("m", RandomPoints(random, 1, 1000)).ok());
  const server::Head before = HeadOf();
  const EditBatch good = RandomPoints(random, 10'000, count());
  const FeatureId bad = 9'000'000;
  const auto& first = good.front().feature;
  struct Case {
    Edit edit;
    absl::StatusCode code;
    const char* reason;
  };
  const std::vector<Case> cases = {
      {Edit::Add(Feature::Point(bad, std::numeric_limits<double>::quiet_NaN(), 0.5)),
       absl::StatusCode::kInvalidArgument, reason::kNotFinite},
      {Edit::Add(Feature::Point(bad, 2, 0.5)), absl::StatusCode::kInvalidArgument,
       reason::kOutsideBox},
      {Edit::Remove(bad), absl::StatusCode::kNotFound, reason::kUnknownFeature},
      {Edit::Add(Feature::Point(bad, first.position[0], first.position[1])),
       absl::StatusCode::kFailedPrecondition, reason::kDuplicatePoint},
      {Edit::Add(Feature::Segment(bad, 1, bad + 1)), absl::StatusCode::kFailedPrecondition,
       reason::kUnknownEnd},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.reason);
    EditBatch batch = good;
    batch.push_back(c.edit);
    const absl::Status status = client_->Apply("m", batch).status();
    EXPECT_EQ(status.code(), c.code) << status;
    const auto error = codec::GetServiceError(status);
    ASSERT_TRUE(error.has_value()) << status;
    EXPECT_EQ(error->reason, c.reason);
    const auto features = error->Features();
    EXPECT_NE(std::find(features.begin(), features.end(), bad), features.end()) << status;
    EXPECT_NE(status.message().find(std::to_string(bad)), std::string::npos) << status;
    EXPECT_EQ(HeadOf().revision, before.revision);
    EXPECT_EQ(HeadOf().hash, before.hash);
  }
  client::EditParams stale;
  stale.expected_revision = before.revision - 1;
  EXPECT_EQ(client_->Apply("m", good, stale).status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(HeadOf().hash, before.hash);
  EXPECT_EQ(ComputeHash(*client_->GetSnapshot("m")), before.hash);
  // The places of the refused edits are free again.
  EXPECT_TRUE(client_->Apply("m", {good.front()}).ok());
}

}  // namespace
}  // namespace dynmesh::large_test
