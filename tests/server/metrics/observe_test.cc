// What a server reports of itself: counted calls, and ids of calls.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "proto/codec/grpc_status.h"
#include "server/metrics/failed_calls.h"
#include "tests/server/metrics/observe_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::observe_test {
namespace {
TEST_F(ObserveTest, CallsAreCountedByMethodAndCode) {
  StartObserved();  // CreateMesh
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(client_->GetStats("m").ok());
  for (int i = 0; i < 3; ++i) ASSERT_FALSE(client_->GetMesh("none").ok());
  for (FeatureId id = 1; id <= 2; ++id) ASSERT_TRUE(client_->Apply("m", {AddPoint(id)}).ok());
  {
    const auto stream = client_->OpenEdits("m");
    for (FeatureId id = 3; id <= 7; ++id) {
      ASSERT_TRUE(stream->Send({AddPoint(id)}, {}).ok());
      ASSERT_TRUE(stream->Receive()->result.ok());
    }
    ASSERT_TRUE(stream->DoneSending().ok());
    EXPECT_FALSE(stream->Receive().has_value());
    ASSERT_TRUE(stream->Finish().ok());
  }
  // The server counts it a moment after the client has its answer.
  const ParsedMetrics::Labels send = {{"stage", "send"}, {"kind", "edit"}};
  test::WaitUntil("the count of edits",
                  [&] { return Scrape().Value("dynmesh_edit_seconds_count", send) >= 7; });
  const ParsedMetrics now = Scrape();
  EXPECT_EQ(now.Value("grpc_server_started_total", Of("unary", "CreateMesh")), 1);
  EXPECT_EQ(now.Value("grpc_server_handled_total", Of("unary", "CreateMesh", "OK")), 1);
  EXPECT_EQ(now.Value("grpc_server_started_total", Of("unary", "GetStats")), 4);
  EXPECT_EQ(now.Value("grpc_server_handled_total", Of("unary", "GetStats", "OK")), 4);
  EXPECT_EQ(now.Value("grpc_server_msg_received_total", Of("unary", "GetStats")), 4);
  EXPECT_EQ(now.Value("grpc_server_msg_sent_total", Of("unary", "GetStats")), 4);
  EXPECT_EQ(now.Value("grpc_server_handling_seconds_count", Of("unary", "GetStats")), 4);
  EXPECT_EQ(now.Value("grpc_server_handled_total", Of("unary", "GetMesh", "NotFound")), 3);
  EXPECT_TRUE(std::isnan(now.Value("grpc_server_handled_total", Of("unary", "GetMesh", "OK"))));
  EXPECT_EQ(now.Value("grpc_server_started_total", Of("unary", "ListMeshes")), 0);
  // Streams: a message each way for each batch.
  EXPECT_EQ(now.Value("grpc_server_handled_total", Of("bidi_stream", "EditStream", "OK")), 1);
  EXPECT_EQ(now.Value("grpc_server_msg_received_total", Of("bidi_stream", "EditStream")), 5);
  EXPECT_EQ(now.Value("grpc_server_msg_sent_total", Of("bidi_stream", "EditStream")), 5);
  EXPECT_EQ(now.Value("dynmesh_edits_total", {{"result", "applied"}}), 7);
  EXPECT_EQ(now.Value("dynmesh_mesh_revision", {{"mesh", "m"}}), 7);
  EXPECT_EQ(now.Value("dynmesh_edit_seconds_count", {{"stage", "propagate"}, {"kind", "edit"}}), 7);
  EXPECT_EQ(now.Value("dynmesh_edit_seconds_count", send), 7);
  EXPECT_FALSE(now.Has("dynmesh_journal_syncs_total"));  // there is no journal
}

TEST_F(ObserveTest, LoadsAndRevertsAreTimedApartFromEdits) {
  StartObserved();
  const std::vector<Feature> points = {AddPoint(1).feature, AddPoint(2).feature};
  ASSERT_TRUE(client_->Load("m", points).ok());
  ASSERT_TRUE(client_->Apply("m", {AddPoint(3)}).ok());
  ASSERT_TRUE(client_->Apply("m", {AddPoint(4)}).ok());
  const ParsedMetrics now = Scrape();
  const auto count = [&](const char* kind) {
    return now.Value("dynmesh_edit_seconds_count", {{"stage", "propagate"}, {"kind", kind}});
  };
  EXPECT_EQ(count("load"), 1);
  EXPECT_EQ(count("edit"), 2);
  EXPECT_EQ(count("revert"), 0);
}

TEST_F(ObserveTest, BuildsAreCountedByResult) {
  StartObserved();
  std::vector<Feature> points = {AddPoint(1).feature, AddPoint(2).feature};
  ASSERT_TRUE(client_->BuildMesh(points, MeshOptions()).ok());
  points.push_back(points.front());
  ASSERT_FALSE(client_->BuildMesh(points, MeshOptions()).ok());
  const auto running = [this] { return Scrape().Value("dynmesh_builds_running", {}); };
  build_gate_->Hold();
  grpc::ClientContext context;
  const auto build = stub_->BuildMesh(&context);
  v1::BuildMeshRequest request;
  request.mutable_options()->mutable_box()->mutable_hi()->set_x(1);
  request.mutable_options()->mutable_box()->mutable_lo();
  request.set_last(true);
  ASSERT_TRUE(build->Write(request));
  test::WaitUntil("the start of a build", [&] { return running() == 1; });
  context.TryCancel();
  test::WaitUntil("the end of a build", [&] { return running() == 0; });
  const ParsedMetrics now = Scrape();
  for (const char* result : {"built", "refused", "cancelled"}) {
    EXPECT_EQ(now.Value("dynmesh_builds_total", {{"result", result}}), 1) << result;
  }
  EXPECT_EQ(now.Value("dynmesh_builds_total", {{"result", "failed"}}), 0);
  EXPECT_EQ(now.Value("dynmesh_build_seconds_count", {}), 1);
  EXPECT_EQ(now.Value("grpc_server_started_total", Of("bidi_stream", "BuildMesh")), 3);
}

// By the snapshot's own size: the rest is each message's overhead.
TEST_F(ObserveTest, BytesSentAreCounted) {
  StartObserved();
  for (FeatureId id = 1; id <= 5; ++id) ASSERT_TRUE(client_->Apply("m", {AddPoint(id)}).ok());
  const ParsedMetrics::Labels snapshot = Of("server_stream", "GetSnapshot");
  EXPECT_EQ(Scrape().Value("dynmesh_sent_bytes_total", snapshot), 0);
  grpc::ClientContext context;
  v1::GetSnapshotRequest request;
  request.set_mesh("meshes/m");
  const auto reader = stub_->GetSnapshot(&context, request);
  std::size_t bytes = 0;
  for (v1::SnapshotChunk chunk; reader->Read(&chunk);) bytes += chunk.ByteSizeLong();
  ASSERT_TRUE(reader->Finish().ok());
  EXPECT_GT(bytes, 100u);
  EXPECT_EQ(Scrape().Value("dynmesh_sent_bytes_total", snapshot), static_cast<double>(bytes));
}

TEST_F(ObserveTest, ABatchThatRunsShowsHowFarItIs) {
  StartObserved();
  const ParsedMetrics::Labels m = {{"mesh", "m"}};
  const ParsedMetrics::Labels stage = {{"mesh", "m"}, {"stage", "propagate"}};
  gate_->Hold();
  std::thread editor([&] { EXPECT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2)}).ok()); });
  gate_->WaitForArrivals(1);
  const ParsedMetrics running = Scrape();
  EXPECT_EQ(running.Value("dynmesh_mesh_batch_edits", m), 2);
  EXPECT_EQ(running.Value("dynmesh_mesh_batch_work_done", stage), 2);
  EXPECT_EQ(running.Value("dynmesh_mesh_batch_work", stage), 4);
  EXPECT_EQ(running.Value("dynmesh_mesh_batch_done_ratio", stage), 0.5);
  gate_->Release();
  editor.join();
  test::WaitUntil("the batch's end",
                  [&] { return Scrape().Value("dynmesh_mesh_batch_edits", m) == 0; });
  EXPECT_TRUE(std::isnan(Scrape().Value("dynmesh_mesh_batch_work_done", stage)));
}

TEST_F(ObserveTest, AClientThatGoesAwayIsCountedAsCancelled) {
  StartObserved();
  {
    const auto watch = client_->Watch("m", {.max_attempts = 0}, nullptr);
    ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
    EXPECT_EQ(Scrape().Value("dynmesh_mesh_watchers", {{"mesh", "m"}}), 1);
  }
  const auto ended = Of("server_stream", "Watch", "Canceled");
  test::WaitUntil("the call's end",
                  [&] { return Scrape().Value("grpc_server_handled_total", ended) == 1; });
  EXPECT_EQ(Scrape().Value("grpc_server_started_total", Of("server_stream", "Watch")), 1);
}

TEST_F(ObserveTest, MethodsThatClientsInventAreOneAtMost) {
  StartObserved();
  const std::size_t before = Scrape().size();
  for (int i = 0; i < 5; ++i) {
    grpc::Status status;
    CallBytes("/x/Invented" + std::to_string(i), "", &status);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED);
  }
  EXPECT_LE(Scrape().size(), before + 1);
}

TEST_F(ObserveTest, ScrapesDuringEditsAgreeWithThemInTheEnd) {
  StartObserved();
  std::atomic<bool> done{false};
  std::thread scraper([&] {
    double before = 0;
    while (!done) {
      const double now = Scrape().Value("dynmesh_edits_total", {{"result", "applied"}});
      EXPECT_GE(now, before);
      before = now;
    }
  });
  for (FeatureId id = 1; id <= 200; ++id) ASSERT_TRUE(client_->Apply("m", {AddPoint(id)}).ok());
  done = true;
  scraper.join();
  EXPECT_EQ(Scrape().Value("dynmesh_edits_total", {{"result", "applied"}}), 200);
}

// ------------------------------------------------------------------ ids of calls

// What comes back for what is sent; "" for nothing.
std::string Echo(v1::MeshService::Stub& stub, const char* sent, const std::string& mesh) {
  grpc::ClientContext context;
  if (sent != nullptr) context.AddMetadata("x-request-id", sent);
  v1::GetMeshRequest request;
  request.set_mesh(mesh);
  v1::Mesh response;
  stub.GetMesh(&context, request, &response);
  for (const auto* metadata :
       {&context.GetServerInitialMetadata(), &context.GetServerTrailingMetadata()}) {
    if (const auto it = metadata->find("x-request-id"); it != metadata->end()) {
      return {it->second.data(), it->second.size()};
    }
  }
  return "";
}

TEST_F(ObserveTest, EveryCallHasAnIdAndTheClientLearnsIt) {
  StartWithMesh();
  EXPECT_EQ(Echo(*stub_, "trace-17", "meshes/m"), "trace-17");
  EXPECT_EQ(Echo(*stub_, "trace-18", "meshes/none"), "trace-18");  // also with an error
  const std::string fresh = Echo(*stub_, nullptr, "meshes/m");
  EXPECT_EQ(fresh.size(), 16u);
  EXPECT_NE(Echo(*stub_, nullptr, "meshes/m"), fresh);
  EXPECT_EQ(Echo(*stub_, std::string(65, 'x').c_str(), "meshes/m").size(), 16u);
  EXPECT_EQ(Echo(*stub_, "a b", "meshes/m").size(), 16u);
}

TEST_F(ObserveTest, LinesOfAnEditAndOfAnErrorHaveTheId) {
  StartWithMesh();
  ASSERT_TRUE(SetLogLevel("debug").ok());
  testing::internal::CaptureStderr();
  {
    grpc::ClientContext context;
    context.AddMetadata("x-request-id", "edit-1");
    v1::AddFeaturesRequest request;
    request.set_mesh("meshes/m");
    auto* feature = request.add_features();
    feature->set_id(1);
    feature->mutable_point()->set_x(0.25);
    feature->mutable_point()->set_y(0.5);
    v1::MeshDiff diff;
    const auto reader = stub_->AddFeatures(&context, request);
    while (reader->Read(&diff)) {
    }
    EXPECT_TRUE(reader->Finish().ok());
  }
  Echo(*stub_, "bad-1", "meshes/none");
  server_.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("error").ok());
  EXPECT_NE(log.find("event=edit mesh=m call=edit-1 "), std::string::npos) << log;
  EXPECT_NE(log.find("event=call_failed call=bad-1 method=GetMesh code=NotFound"),
            std::string::npos)
      << log;
}

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// Of many refusals one per second is logged.
TEST_F(ObserveTest, WhoIsRefusedIsToldNowAndThenAndCountedAlways) {
  MetricRegistry metrics;
  FailedCalls calls(metrics);
  codec::ServiceError error;
  error.reason = codec::reason::kRateLimit;
  error.metadata["client"] = "token lab";
  const grpc::Status refused = codec::ToGrpcStatus(
      codec::MakeServiceError(absl::StatusCode::kResourceExhausted, "slow down", error));
  error.reason = codec::reason::kRoleMissing;
  const grpc::Status other = codec::ToGrpcStatus(
      codec::MakeServiceError(absl::StatusCode::kPermissionDenied, "no", error));
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  const auto begin = MetricsClock::now();
  std::uint64_t told = 0;
  const auto refuse = [&] {
    calls.Tell({"id", "ApplyEdits", "ResourceExhausted", "ipv4:10.0.0.7:1234"}, refused);
    ++told;
  };
  while (MetricsClock::now() - begin < std::chrono::milliseconds(1100)) refuse();
  refuse();
  calls.Tell({"id", "Watch", "PermissionDenied", "ipv4:10.0.0.7:1234"}, other);
  calls.Tell({"id", "Watch", "Canceled", ""}, grpc::Status::CANCELLED);
  // The error of a mesh's limit does not name the client.
  error.reason = codec::reason::kQueueFull;
  error.metadata.clear();
  calls.Tell({"id", "ApplyEdits", "ResourceExhausted", "ipv4:10.0.0.7:1234"},
             codec::ToGrpcStatus(codec::MakeServiceError(absl::StatusCode::kResourceExhausted,
                                                         "the queue is full", error)));
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("error").ok());
  const std::string line =
      "event=call_refused call=id method=ApplyEdits code=ResourceExhausted reason=RATE_LIMIT "
      "client=\"token lab\" peer=ipv4:10.0.0.7:1234 left_out=";
  EXPECT_GE(Count(log, line), 2u) << log;  // one was at the beginning, one a second later
  EXPECT_LE(Count(log, line), told / 10) << log;
  EXPECT_EQ(Count(log, line + "0 "), 1u) << log;
  EXPECT_EQ(Count(log, "reason=ROLE_MISSING"), 1u) << log;
  EXPECT_EQ(Count(log, "Canceled"), 0u) << log;
  EXPECT_EQ(Count(log, "reason=QUEUE_FULL client=\"address ipv4:10.0.0.7\" peer="), 1u) << log;
  const ParsedMetrics now(metrics.Text());
  EXPECT_EQ(now.Value("dynmesh_failed_calls_total", {{"reason", "RATE_LIMIT"}}), told);
  EXPECT_EQ(now.Value("dynmesh_failed_calls_total", {{"reason", "ROLE_MISSING"}}), 1);
}

// gRPC's own services answer INTERNAL to what a client resets: no token is needed for that.
TEST_F(ObserveTest, ThousandsOfFailuresAreFewLines) {
  MetricRegistry metrics;
  FailedCalls calls(metrics);
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  for (int i = 0; i < 1000; ++i) {
    calls.Tell({"id", "Watch", "Internal", "ipv4:10.0.0.7:1234"},
               grpc::Status(grpc::StatusCode::INTERNAL, ""));
    calls.Tell({"id", "Watch", "DataLoss", "ipv4:10.0.0.7:1234"},
               grpc::Status(grpc::StatusCode::DATA_LOSS, ""));
  }
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("error").ok());
  EXPECT_GE(Count(log, "level=warning event=call_failed call=id method=Watch code=Internal"), 1u);
  EXPECT_GE(Count(log, "code=DataLoss"), 1u) << log;
  EXPECT_LE(Count(log, "call_failed"), 100u) << log;
}

TEST_F(ObserveTest, LinesTellWhoMadeAndDeletedAMesh) {
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  StartWithMesh();
  {
    grpc::ClientContext context;
    context.AddMetadata("x-request-id", "gone-1");
    v1::DeleteMeshRequest request;
    request.set_mesh("meshes/m");
    v1::DeleteMeshResponse response;
    EXPECT_TRUE(stub_->DeleteMesh(&context, request, &response).ok());
  }
  server_.reset();
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("error").ok());
  EXPECT_NE(log.find("event=mesh_created mesh=m meshes=1 client=\"address ipv4:127.0.0.1\" call="),
            std::string::npos)
      << log;
  EXPECT_NE(log.find("event=mesh_deleted mesh=m client=\"address ipv4:127.0.0.1\" call=gone-1"),
            std::string::npos)
      << log;
}

}  // namespace
}  // namespace dynmesh::server::observe_test
