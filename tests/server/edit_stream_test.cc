// EditStream over loopback, with fake meshes: order, refusals, parts, back-pressure.
#include <gtest/gtest.h>

#include <optional>
#include <thread>

#include "dynmesh/error.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::edit_stream_test {
namespace {

using EditStreamTest = ServerFixture;
using absl::StatusCode;

TEST_F(EditStreamTest, PipelinedBatchesAreAnsweredInOrder) {
  StartWithMesh();
  const auto session = client_->OpenEdits("m");
  constexpr int kCount = 500;
  std::thread sender([&] {
    for (int i = 1; i <= kCount; ++i) {
      const auto id = static_cast<FeatureId>(i);
      ASSERT_TRUE(session->Send({AddPoint(id)}, Id(std::to_string(i))).ok());
    }
    ASSERT_TRUE(session->DoneSending().ok());
  });
  for (int i = 1; i <= kCount; ++i) {
    const auto answer = session->Receive();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->request_id, std::to_string(i));
    ASSERT_TRUE(answer->result.ok());
    EXPECT_EQ(answer->result->diff.to_revision, static_cast<std::uint64_t>(i));
  }
  sender.join();
  EXPECT_FALSE(session->Receive().has_value());
  EXPECT_TRUE(session->Finish().ok());
  EXPECT_EQ(HeadOf().revision, static_cast<std::uint64_t>(kCount));
}

TEST_F(EditStreamTest, ARefusedBatchDoesNotEndTheStream) {
  StartWithMesh();
  const auto session = client_->OpenEdits("m");
  ASSERT_TRUE(session->Send({AddPoint(1)}, Id("a")).ok());
  ASSERT_TRUE(session->Send({Edit::Remove(9)}, Id("b")).ok());
  ASSERT_TRUE(session->Send({AddPoint(2)}, Id("c")).ok());
  ASSERT_TRUE(session->Send({AddPoint(3)}, Id(std::string(200, 'd'))).ok());
  ASSERT_TRUE(session->DoneSending().ok());
  EXPECT_TRUE(session->Receive()->result.ok());
  const auto refused = session->Receive();
  EXPECT_EQ(refused->request_id, "b");
  EXPECT_EQ(ReasonOf(refused->result.status()), reason::kUnknownFeature);
  EXPECT_EQ(session->Receive()->result->diff.to_revision, 2u);
  EXPECT_EQ(ReasonOf(session->Receive()->result.status()), codec::reason::kBadRequestId);
  EXPECT_FALSE(session->Receive().has_value());
  EXPECT_TRUE(session->Finish().ok());
}

TEST_F(EditStreamTest, StopOnErrorEndsTheStreamAndWhatFollowsIsNotApplied) {
  StartWithMesh();
  const auto session = client_->OpenEdits("m", /*stop_on_error=*/true);
  gate_->Hold();
  ASSERT_TRUE(session->Send({AddPoint(1)}, Id("a")).ok());
  ASSERT_TRUE(session->Send({Edit::Remove(9)}, Id("b")).ok());
  ASSERT_TRUE(session->Send({AddPoint(2)}, Id("c")).ok());
  gate_->WaitForArrivals(1);
  gate_->Release();
  EXPECT_TRUE(session->Receive()->result.ok());
  EXPECT_EQ(ReasonOf(session->Receive()->result.status()), reason::kUnknownFeature);
  EXPECT_FALSE(session->Receive().has_value());
  EXPECT_EQ(ReasonOf(session->Finish()), reason::kUnknownFeature);
  EXPECT_EQ(HeadOf().revision, 1u);
}

// Raw, to send what the client library would not.
class RawEditStream {
 public:
  explicit RawEditStream(v1::MeshService::Stub& stub) : stream_(stub.EditStream(&context_)) {}
  v1::EditBatch& message() { return message_; }
  bool Send() {
    const bool ok = stream_->Write(message_);
    message_.Clear();
    return ok;
  }
  void Add(const Edit& edit) { codec::EncodeEdit(edit, 2, message_.add_edits()); }
  std::optional<v1::MeshDiff> Receive() {
    v1::MeshDiff answer;
    if (!stream_->Read(&answer)) return std::nullopt;
    return answer;
  }
  absl::Status Finish() {
    stream_->WritesDone();
    while (Receive().has_value()) {
    }
    return codec::FromGrpcStatus(stream_->Finish());
  }
  grpc::ClientContext& context() { return context_; }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::EditBatch, v1::MeshDiff>> stream_;
  v1::EditBatch message_;
};

TEST_F(EditStreamTest, ABatchInPartsIsAppliedWhenComplete) {
  StartWithMesh();
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  stream.message().set_request_id("a");
  stream.message().set_more(true);
  stream.Add(AddPoint(1));
  ASSERT_TRUE(stream.Send());
  stream.message().set_more(true);
  stream.Add(AddPoint(2));
  ASSERT_TRUE(stream.Send());
  ASSERT_TRUE(stream.Send());  // the last part may be empty
  const auto answer = stream.Receive();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->request_id(), "a");
  EXPECT_EQ(answer->added_vertices().ids_size(), 2);
  EXPECT_EQ(answer->to_revision(), 1u);
  EXPECT_TRUE(stream.Finish().ok());
}

TEST_F(EditStreamTest, AnUnfinishedBatchIsNotApplied) {
  StartWithMesh();
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  stream.message().set_more(true);
  stream.Add(AddPoint(1));
  ASSERT_TRUE(stream.Send());
  EXPECT_EQ(ReasonOf(stream.Finish()), codec::reason::kBatchIncomplete);
  EXPECT_EQ(HeadOf().revision, 0u);
}

TEST_F(EditStreamTest, ABatchLeftUnfinishedIsGivenUp) {
  ServerConfig config;
  config.batch_timeout = absl::Milliseconds(200);
  config.max_batch_edits = config.max_pending_edits = 2;
  StartWithMesh(config);
  const auto idle = client_->OpenEdits("m");
  ASSERT_TRUE(idle->Send({AddPoint(1)}, Id("a")).ok());
  EXPECT_TRUE(idle->Receive()->result.ok());
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  stream.message().set_more(true);
  stream.Add(AddPoint(2));
  ASSERT_TRUE(stream.Send());
  EXPECT_FALSE(stream.Receive().has_value());  // nothing more is sent
  const absl::Status status = stream.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(ReasonOf(status), codec::reason::kBatchIncomplete);
  // Its reservations are released soon, and a client that is idle between batches continues.
  absl::Status applied;
  test::WaitUntil("the release of its reservations", [&] {
    EXPECT_TRUE(idle->Send({AddPoint(3), AddPoint(4)}, Id("b")).ok());
    applied = idle->Receive()->result.status();
    return ReasonOf(applied) != codec::reason::kPendingLimit;
  });
  EXPECT_TRUE(applied.ok()) << Text(applied);
  EXPECT_EQ(HeadOf().revision, 2u);
}

TEST_F(EditStreamTest, PartsWithoutEditsDoNotKeepABatch) {
  ServerConfig config;
  config.batch_timeout = absl::Milliseconds(300);
  StartWithMesh(config);
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  stream.message().set_more(true);
  stream.Add(AddPoint(1));
  ASSERT_TRUE(stream.Send());
  EXPECT_TRUE(Eventually([&] {
    stream.message().set_more(true);
    return !stream.Send();
  }));
  const absl::Status status = stream.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(ReasonOf(status), codec::reason::kBatchIncomplete);
  EXPECT_EQ(HeadOf().revision, 0u);
}

TEST_F(EditStreamTest, StreamsThatSayNothingTakeNoPlaceAndEnd) {
  ServerConfig config;
  config.batch_timeout = absl::Milliseconds(300);
  config.max_edit_streams = 1;
  StartWithMesh(config);
  std::vector<std::unique_ptr<RawEditStream>> silent;
  grpc::ClientContext context;
  v1::LoadFeaturesResponse told;
  for (int i = 0; i < 20; ++i) silent.push_back(std::make_unique<RawEditStream>(*stub_));
  const auto load = stub_->LoadFeatures(&context);
  const auto edits = client_->OpenEdits("m");
  ASSERT_TRUE(edits->Send({AddPoint(1)}).ok());
  EXPECT_TRUE(edits->Receive()->result.ok());
  for (const auto& stream : silent) {
    EXPECT_FALSE(stream->Receive().has_value());
    EXPECT_EQ(ReasonOf(stream->Finish()), codec::reason::kBatchIncomplete);
  }
  EXPECT_FALSE(load->Read(&told));
  EXPECT_EQ(load->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(EditStreamTest, ADrainEndsAStreamThatSaysNothing) {
  StartWithMesh();
  RawEditStream stream(*stub_);
  grpc::ClientContext context;
  const auto load = stub_->LoadFeatures(&context);
  // The server has received both when it has answered the batches after them.
  v1::GetMeshRequest request;
  request.set_mesh("meshes/m");
  v1::Mesh mesh;
  grpc::ClientContext behind;
  ASSERT_TRUE(stub_->GetMesh(&behind, request, &mesh).ok());
  EXPECT_TRUE(server_->Drain(kLong));
  EXPECT_EQ(ReasonOf(stream.Finish()), codec::reason::kDraining);
  EXPECT_EQ(ReasonOf(codec::FromGrpcStatus(load->Finish())), codec::reason::kDraining);
}

TEST_F(EditStreamTest, AStreamNamesOneMeshThatExists) {
  StartWithMesh();
  {
    RawEditStream stream(*stub_);
    stream.message().set_mesh("meshes/none");
    ASSERT_TRUE(stream.Send());
    EXPECT_EQ(ReasonOf(stream.Finish()), codec::reason::kMeshNotFound);
  }
  {
    RawEditStream stream(*stub_);
    stream.Add(AddPoint(1));
    ASSERT_TRUE(stream.Send());
    EXPECT_EQ(ReasonOf(stream.Finish()), codec::reason::kBadName);
  }
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  ASSERT_TRUE(stream.Send());
  stream.message().set_mesh("meshes/n");
  stream.Add(AddPoint(1));
  stream.Send();
  EXPECT_EQ(stream.Finish().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(HeadOf().revision, 0u);
}

TEST_F(EditStreamTest, TheRestOfABadBatchIsSkipped) {
  ServerConfig config;
  config.max_batch_edits = 3;
  config.max_pending_edits = 3;
  StartWithMesh(config);
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  for (int part = 0; part < 5; ++part) {
    stream.message().set_request_id("large");
    stream.message().set_more(part < 4);
    stream.Add(AddPoint(static_cast<FeatureId>(part) + 1));
    ASSERT_TRUE(stream.Send());
  }
  stream.message().set_request_id("bare");
  stream.message().add_edits()->mutable_add()->set_id(7);  // no geometry
  ASSERT_TRUE(stream.Send());
  stream.message().set_request_id("good");
  stream.Add(AddPoint(1));
  ASSERT_TRUE(stream.Send());
  const auto large = stream.Receive();
  EXPECT_EQ(large->request_id(), "large");
  EXPECT_EQ(ReasonOf(codec::StatusFromProto(large->status())), codec::reason::kBatchTooLarge);
  const auto bare = stream.Receive();
  EXPECT_EQ(ReasonOf(codec::StatusFromProto(bare->status())), reason::kWrongKind);
  const auto good = stream.Receive();
  EXPECT_EQ(good->request_id(), "good");
  EXPECT_EQ(good->status().code(), 0);
  EXPECT_TRUE(stream.Finish().ok());
}

TEST_F(EditStreamTest, TheServerReadsNoMoreThanItsWindow) {
  ServerConfig config;
  config.edit_window = 4;
  StartWithMesh(config);
  gate_->Hold();
  RawEditStream stream(*stub_);
  constexpr int kCount = 50;
  for (int i = 1; i <= kCount; ++i) {
    stream.message().set_mesh("meshes/m");
    stream.Add(AddPoint(static_cast<FeatureId>(i)));
    ASSERT_TRUE(stream.Send());  // gRPC's buffers hold these
  }
  gate_->WaitForArrivals(1);
  // One runs; three can be waiting, and never more.
  for (int look = 0; look < 50; ++look) {
    EXPECT_LE(Host()->waiting(), 3u);
    std::this_thread::yield();
  }
  gate_->Release();
  for (int i = 1; i <= kCount; ++i) {
    const auto answer = stream.Receive();
    ASSERT_TRUE(answer.has_value());
    EXPECT_EQ(answer->to_revision(), static_cast<std::uint64_t>(i));
  }
  EXPECT_TRUE(stream.Finish().ok());
}

// The server reads no batch while an answer waits to be sent. (How far it runs ahead of the client
// is up to gRPC, which takes some answers: its windows grow with time.)
TEST_F(EditStreamTest, AnswersArriveInOrderHoweverFewBytesMayWait) {
  ServerConfig config;
  config.edit_answer_bytes = 1;
  StartWithMesh(config);
  RawEditStream stream(*stub_);
  constexpr int kCount = 12, kPoints = 4'000;
  std::thread sender([&] {
    for (int i = 0; i < kCount; ++i) {
      stream.message().set_mesh("meshes/m");
      for (const Edit& edit : ManyPoints(static_cast<FeatureId>(1 + i * kPoints), kPoints)) {
        stream.Add(edit);
      }
      EXPECT_TRUE(stream.Send());
    }
  });
  for (int i = 1; i <= kCount; ++i) {
    auto part = stream.Receive();
    while (part.has_value() && part->more()) part = stream.Receive();
    EXPECT_EQ(part->to_revision(), static_cast<std::uint64_t>(i));
  }
  sender.join();
  EXPECT_TRUE(stream.Finish().ok());
}

TEST_F(EditStreamTest, ACancelledStreamLeavesTheMeshUsable) {
  StartWithMesh();
  gate_->Hold();
  {
    RawEditStream stream(*stub_);
    for (FeatureId id = 1; id <= 100; ++id) {
      stream.message().set_mesh("meshes/m");
      stream.Add(AddPoint(id));
      ASSERT_TRUE(stream.Send());
    }
    gate_->WaitForArrivals(1);
    stream.context().TryCancel();
    EXPECT_EQ(stream.Finish().code(), StatusCode::kCancelled);
  }
  gate_->Release();
  EXPECT_TRUE(client_->Apply("m", {AddPoint(1000)}).ok());
  // The stream gave back its place and its edits.
  EXPECT_TRUE(client_->OpenEdits("m")->Send({AddPoint(1001)}).ok());
}

// Reads, writes and the end of a stream occur in every order; nothing may be started on a deleted
// stream. Mostly useful with a sanitizer.
TEST_F(EditStreamTest, StreamsMayBeCancelledAtAnyMoment) {
  ServerConfig config;
  config.edit_window = 3;  // reading stops and goes on all the time
  StartWithMesh(config);
  const auto edits_of = [this](FeatureId base) {
    for (int round = 0; round < 100; ++round) {
      const auto session = client_->OpenEdits("m");
      std::thread sender([&] {
        for (FeatureId id = base; session->Send({AddPoint(id)}).ok(); ++id) {
          if (!session->Send({Edit::Remove(id)}).ok()) break;
        }
      });
      for (int i = 0; i < round % 7; ++i) session->Receive();
      session->Cancel();
      while (session->Receive().has_value()) {
      }
      EXPECT_EQ(session->Finish().code(), StatusCode::kCancelled);
      sender.join();
    }
  };
  std::thread other([&] { edits_of(1'000'000); });
  edits_of(1);
  other.join();
  EXPECT_TRUE(client_->Apply("m", {AddPoint(2'000'000)}).ok());
}

}  // namespace
}  // namespace dynmesh::server::edit_stream_test
