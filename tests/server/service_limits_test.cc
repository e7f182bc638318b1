// What ends a call before it is done, and limits: deadlines, cancellation, places in queues, sizes.
#include <gtest/gtest.h>

#include <thread>

#include "dynmesh/error.h"
#include "proto/codec/edit_codec.h"
#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::service_limits_test {
namespace {

using ServiceLimits = ServerFixture;
using absl::StatusCode;

TEST_F(ServiceLimits, AnEditPastItsDeadlineIsUndone) {
  StartWithMesh();
  const Head before = HeadOf();
  gate_->Hold();
  client::ClientOptions hurried;
  hurried.timeout = absl::Milliseconds(50);
  const auto client = client::MeshClient::Connect(server_->address(), hurried);
  EXPECT_EQ(client->Apply("m", {AddPoint(1)}).status().code(), StatusCode::kDeadlineExceeded);
  // The gate still holds: the edit can only end by the cancellation.
  Mailbox<int> turn;
  ASSERT_TRUE(Host()->Locate({}, nullptr, [&](auto) { turn.Put(0); }).ok());
  turn.Take();
  EXPECT_EQ(HeadOf().revision, before.revision);
  EXPECT_EQ(HeadOf().hash, before.hash);
  gate_->Release();
  EXPECT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
}

TEST_F(ServiceLimits, ACancelledCallIsUndone) {
  StartWithMesh();
  gate_->Hold();
  v1::ApplyEditsRequest request;
  request.set_mesh("meshes/m");
  request.add_edits()->mutable_add()->set_id(1);
  request.mutable_edits(0)->mutable_add()->mutable_point()->set_x(0.5);
  grpc::ClientContext context;
  const auto reader = stub_->ApplyEdits(&context, request);
  gate_->WaitForArrivals(1);
  context.TryCancel();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  Mailbox<int> turn;
  ASSERT_TRUE(Host()->Locate({}, nullptr, [&](auto) { turn.Put(0); }).ok());
  turn.Take();
  EXPECT_EQ(HeadOf().revision, 0u);
  gate_->Release();
}

TEST_F(ServiceLimits, CancelledCallsGiveUpTheirPlacesWhileTheirMeshIsBusy) {
  ServerConfig config;
  config.max_pending_edits = config.max_batch_edits = 10;
  config.max_waiting_edits = 4;
  StartWithMesh(config);
  ASSERT_TRUE(client_->CreateMesh("n", {}).ok());
  gate_->Hold();
  grpc::ClientContext busy_context;
  v1::ApplyEditsRequest request;
  request.set_mesh("meshes/m");
  codec::EncodeEdit(AddPoint(1), 2, request.add_edits());
  const auto busy = stub_->ApplyEdits(&busy_context, request);
  gate_->WaitForArrivals(1);
  for (FeatureId id = 2; id <= 4; ++id) codec::EncodeEdit(AddPoint(id), 2, request.add_edits());

  // A call, a stream and a load that reserve much each; and a query.
  grpc::ClientContext call_context, stream_context, load_context, locate_context;
  const auto call = stub_->ApplyEdits(&call_context, request);
  const auto stream = stub_->EditStream(&stream_context);
  v1::EditBatch batch;
  batch.set_mesh("meshes/m");
  for (FeatureId id = 5; id <= 7; ++id) codec::EncodeEdit(AddPoint(id), 2, batch.add_edits());
  ASSERT_TRUE(stream->Write(batch));
  const auto load = stub_->LoadFeatures(&load_context);
  v1::LoadFeaturesRequest part;
  part.set_mesh("meshes/m");
  part.set_last(true);
  codec::EncodeFeature(AddPoint(8).feature, 2, part.add_features());
  ASSERT_TRUE(load->Write(part));
  v1::LocatePointsRequest where;
  where.set_mesh("meshes/m");
  v1::LocatePointsResponse found;
  Mailbox<grpc::Status> located;
  stub_->async()->LocatePoints(&locate_context, &where, &found,
                               [&](grpc::Status status) { located.Put(std::move(status)); });
  ASSERT_TRUE(Eventually([&] { return Host()->waiting() == 4; }));
  client::EditParams dry;
  dry.validate_only = true;
  const EditBatch nine = ManyPoints(100, 9);
  EXPECT_EQ(ReasonOf(client_->Apply("n", nine, dry).status()), codec::reason::kPendingLimit);

  for (grpc::ClientContext* context :
       {&call_context, &stream_context, &load_context, &locate_context}) {
    context->TryCancel();
  }
  EXPECT_EQ(located.Take().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_TRUE(Eventually([&] { return Host()->waiting() == 0; }));
  // All except the one running edit can be used for another mesh.
  EXPECT_TRUE(Eventually([&] { return client_->Apply("n", nine, dry).ok(); }));
  EXPECT_EQ(HeadOf().revision, 0u);
  gate_->Release();
  v1::MeshDiff diff;
  ASSERT_TRUE(busy->Read(&diff));
  EXPECT_EQ(diff.to_revision(), 1u);
  EXPECT_EQ(call->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(load->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_FALSE(busy->Read(&diff));
  EXPECT_TRUE(busy->Finish().ok());
  EXPECT_EQ(HeadOf().revision, 1u);
}

TEST_F(ServiceLimits, LimitsAreKept) {
  ServerConfig config;
  config.max_meshes = 1;
  config.max_batch_edits = 10;
  config.max_pending_edits = 12;
  config.max_watchers = 1;
  config.max_edit_streams = 1;
  config.max_message_bytes = 64 << 10;
  StartWithMesh(config);
  EXPECT_EQ(ReasonOf(client_->CreateMesh("n", {}).status()), codec::reason::kMeshLimit);
  EXPECT_EQ(ReasonOf(client_->Apply("m", ManyPoints(1, 11)).status()),
            codec::reason::kBatchTooLarge);
  EXPECT_EQ(client_->Apply("m", ManyPoints(1, 5000)).status().code(),
            StatusCode::kResourceExhausted);  // gRPC's own limit on messages

  gate_->Hold();
  Mailbox<absl::Status> held;
  std::thread waiting([&] { held.Put(client_->Apply("m", ManyPoints(1, 10)).status()); });
  gate_->WaitForArrivals(1);
  const absl::Status pending = client_->Apply("m", ManyPoints(20, 3)).status();
  EXPECT_EQ(ReasonOf(pending), codec::reason::kPendingLimit);
  EXPECT_TRUE(codec::GetServiceError(pending)->retry_after.has_value());
  gate_->Release();
  waiting.join();
  EXPECT_TRUE(held.Take().ok());
  EXPECT_TRUE(client_->Apply("m", ManyPoints(20, 3)).ok());

  const auto watch = client_->Watch("m", {}, nullptr);
  ASSERT_TRUE(watch->WaitForRevision(2, kLong));
  client::WatchOptions impatient;
  impatient.max_attempts = 0;
  const auto second = client_->Watch("m", impatient, nullptr);
  EXPECT_FALSE(second->WaitForRevision(2, kLong));
  EXPECT_EQ(ReasonOf(*second->ended()), codec::reason::kStreamLimit);

  const auto edits = client_->OpenEdits("m");
  ASSERT_TRUE(edits->Send({AddPoint(100)}).ok());
  ASSERT_TRUE(edits->Receive().has_value());
  const auto third = client_->OpenEdits("m");
  ASSERT_TRUE(third->Send({AddPoint(101)}).ok());
  EXPECT_FALSE(third->Receive().has_value());
  EXPECT_EQ(ReasonOf(third->Finish()), codec::reason::kStreamLimit);
}

TEST_F(ServiceLimits, AClientHasSoManyStreams) {
  ServerConfig config;
  config.max_streams_per_client = 2;
  StartWithMesh(config);
  const auto edits = client_->OpenEdits("m");
  ASSERT_TRUE(edits->Send({AddPoint(1)}).ok());
  ASSERT_TRUE(edits->Receive().has_value());
  client::WatchOptions impatient;
  impatient.max_attempts = 0;
  auto watch = client_->Watch("m", impatient, nullptr);
  ASSERT_TRUE(watch->WaitForRevision(1, kLong));

  const auto second = client_->Watch("m", impatient, nullptr);
  EXPECT_FALSE(second->WaitForRevision(1, kLong));
  EXPECT_EQ(ReasonOf(*second->ended()), codec::reason::kClientStreamLimit);
  EXPECT_FALSE(codec::GetServiceError(*second->ended())->metadata.at("client").empty());
  EXPECT_EQ(ReasonOf(client_->GetSnapshot("m").status()), codec::reason::kClientStreamLimit);
  EXPECT_TRUE(client_->Apply("m", {AddPoint(2)}).ok());  // ends by itself
  watch.reset();
  test::WaitUntil("the server's notice", [&] { return client_->GetSnapshot("m").ok(); });
}

TEST_F(ServiceLimits, AMeshsOwnVertexLimitHolds) {
  StartServer();
  MeshOptions options;
  options.limits.max_vertices = 1000;
  const auto made = client_->CreateMesh("m", options);
  ASSERT_TRUE(made.ok()) << Text(made.status());
  EXPECT_EQ(made->options.limits.max_vertices, 1000u);
  ASSERT_TRUE(client_->Apply("m", ManyPoints(1, 1000)).ok());
  const Head before = HeadOf();
  const absl::Status status = client_->Apply("m", {AddPoint(1001)}).status();
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(status), reason::kVertexLimit);
  EXPECT_EQ(HeadOf().hash, before.hash);
}

}  // namespace
}  // namespace dynmesh::server::service_limits_test
