// EditStream, Watch and the drain over loopback, with fake meshes.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <thread>

#include "dynmesh/error.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "tests/server/server_fixture.h"

namespace dynmesh::server {
namespace {

using StreamTest = ServerFixture;
using absl::StatusCode;

client::EditParams Id(const std::string& id) {
  client::EditParams params;
  params.request_id = id;
  return params;
}

TEST_F(StreamTest, PipelinedBatchesAreAnsweredInOrder) {
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

TEST_F(StreamTest, ARefusedBatchDoesNotEndTheStream) {
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

TEST_F(StreamTest, StopOnErrorEndsTheStreamAndWhatFollowsIsNotApplied) {
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

TEST_F(StreamTest, ABatchInPiecesIsAppliedWhenComplete) {
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
  ASSERT_TRUE(stream.Send());  // the last piece may be empty
  const auto answer = stream.Receive();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->request_id(), "a");
  EXPECT_EQ(answer->added_vertices().ids_size(), 2);
  EXPECT_EQ(answer->to_revision(), 1u);
  EXPECT_TRUE(stream.Finish().ok());
}

TEST_F(StreamTest, AnUnfinishedBatchIsNotApplied) {
  StartWithMesh();
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  stream.message().set_more(true);
  stream.Add(AddPoint(1));
  ASSERT_TRUE(stream.Send());
  EXPECT_EQ(ReasonOf(stream.Finish()), codec::reason::kBatchIncomplete);
  EXPECT_EQ(HeadOf().revision, 0u);
}

TEST_F(StreamTest, AStreamNamesOneMeshThatExists) {
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

TEST_F(StreamTest, TheRestOfABadBatchIsSkipped) {
  ServerConfig config;
  config.max_batch_edits = 3;
  config.max_pending_edits = 3;
  StartWithMesh(config);
  RawEditStream stream(*stub_);
  stream.message().set_mesh("meshes/m");
  for (int piece = 0; piece < 5; ++piece) {
    stream.message().set_request_id("large");
    stream.message().set_more(piece < 4);
    stream.Add(AddPoint(static_cast<FeatureId>(piece) + 1));
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

TEST_F(StreamTest, TheServerReadsNoMoreThanItsWindow) {
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

TEST_F(StreamTest, ACancelledStreamLeavesTheMeshUsable) {
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

TEST_F(StreamTest, AReplicaFollowsAWriter) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  const auto watch = client_->Watch("m", {}, nullptr);
  for (FeatureId id = 10; id < 60; ++id) ASSERT_TRUE(client_->Apply("m", {AddPoint(id)}).ok());
  ASSERT_TRUE(watch->WaitForRevision(51, kLong));
  watch->Read([&](const client::MeshReplica& r) {
    EXPECT_EQ(r.hash(), HeadOf().hash);
    EXPECT_EQ(ComputeHash(r.ToMesh()), HeadOf().hash);
  });
  EXPECT_EQ(watch->resyncs(), 0);
}

TEST_F(StreamTest, AnIdleWatcherHearsOfProgress) {
  StartWithMesh();
  struct Listener : client::WatchListener {
    void OnProgress(const client::MeshReplica&) override { progress.Put(0); }
    Mailbox<int> progress;
  } listener;
  client::WatchOptions options;
  options.progress_interval = absl::Milliseconds(100);
  const auto watch = client_->Watch("m", options, &listener);
  listener.progress.Take();
  listener.progress.Take();
}

TEST_F(StreamTest, WatchesRefuseBadStarts) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  const auto finish = [&](auto change) {
    v1::WatchRequest request;
    request.set_mesh("meshes/m");
    change(request);
    grpc::ClientContext context;
    const auto reader = stub_->Watch(&context, request);
    v1::WatchEvent event;
    EXPECT_FALSE(reader->Read(&event));
    return codec::FromGrpcStatus(reader->Finish());
  };
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.set_start_revision(2); })),
            codec::reason::kFutureRevision);
  EXPECT_EQ(ReasonOf(finish([](auto& r) {
              r.set_start_revision(1);
              r.set_start_hash(MeshHash{1, 1}.ToHex());
            })),
            codec::reason::kDiverged);
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.set_start_hash("xyz"); })), codec::reason::kBadRequest);
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.mutable_progress_interval()->set_seconds(-1); })),
            codec::reason::kBadRequest);
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.set_mesh("meshes/none"); })),
            codec::reason::kMeshNotFound);
}

// The watcher takes one message and then none while the writer makes hundreds of large
// revisions, far more than any buffer on the way holds.
TEST_F(StreamTest, AWatcherThatStopsReadingDoesNotSlowTheWriterAndEndsEqual) {
  ServerConfig config;
  config.history_bytes = 1 << 20;
  StartWithMesh(config);
  v1::WatchRequest request;
  request.set_mesh("meshes/m");
  grpc::ClientContext context;
  const auto reader = stub_->Watch(&context, request);
  client::MeshReplica replica;
  v1::WatchEvent event;
  ASSERT_TRUE(reader->Read(&event));
  ASSERT_TRUE(replica.Take(event).ok());

  EditBatch batch;
  for (FeatureId id = 1; id <= 2000; ++id) batch.push_back(AddPoint(id));
  EditBatch undo;
  for (FeatureId id = 1; id <= 2000; ++id) undo.push_back(Edit::Remove(id));
  client::EditParams params;
  params.omit_columns = true;
  std::uint64_t last = 0;
  for (int round = 0; round < 100; ++round) {
    ASSERT_TRUE(client_->Apply("m", batch, params).ok());
    const auto result = client_->Apply("m", undo, params);
    ASSERT_TRUE(result.ok());
    last = result->diff.to_revision;
  }
  const auto result = client_->Apply("m", batch, params);
  ASSERT_TRUE(result.ok());
  ++last;
  // It never read while the writer wrote, and yet the writer is done.
  while (replica.revision() < last) {
    ASSERT_TRUE(reader->Read(&event));
    const auto change = replica.Take(event);
    ASSERT_TRUE(change.ok()) << Text(change.status());
  }
  EXPECT_EQ(replica.hash(), result->diff.hash);
  context.TryCancel();
  reader->Finish();
}

int ThreadsOfThisProcess() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("Threads:", 0) == 0) return std::stoi(line.substr(8));
  }
  return -1;
}

TEST_F(StreamTest, TwoHundredWatchersEndWithTheServersHash) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  std::vector<std::unique_ptr<client::WatchSession>> watches;
  for (int i = 0; i < 200; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
  for (FeatureId id = 10; id < 110; ++id) ASSERT_TRUE(client_->Apply("m", {AddPoint(id)}).ok());
  for (const auto& watch : watches) {
    ASSERT_TRUE(watch->WaitForRevision(101, kLong));
    watch->Read([&](const client::MeshReplica& r) { EXPECT_EQ(r.hash(), HeadOf().hash); });
    EXPECT_EQ(watch->resyncs(), 0);
  }
}

TEST_F(StreamTest, AThousandIdleWatchersCostNoThreads) {
  StartWithMesh();
  const auto first = client_->Watch("m", {}, nullptr);
  ASSERT_TRUE(first->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
  const int before = ThreadsOfThisProcess();
  ASSERT_GT(before, 0);
  std::vector<std::unique_ptr<client::WatchSession>> watches;
  for (int i = 0; i < 1000; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
  for (const auto& watch : watches) {
    ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
  }
  EXPECT_EQ(client_->GetStats("m")->mesh->watchers, 1001u);
  // Server and client together; gRPC may start a few of its own, whatever the number.
  EXPECT_LT(ThreadsOfThisProcess(), before + 20);
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  for (const auto& watch : watches) ASSERT_TRUE(watch->WaitForRevision(1, kLong));
}

TEST_F(StreamTest, WatchersThatLeaveAreForgotten) {
  StartWithMesh();
  {
    std::vector<std::unique_ptr<client::WatchSession>> watches;
    for (int i = 0; i < 20; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
    for (const auto& watch : watches) {
      ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
    }
  }
  // The server hears of it a little later: of the places first, of the calls then.
  const absl::Time deadline = absl::Now() + kLong;
  while (client_->GetStats()->watchers > 0 && absl::Now() < deadline) std::this_thread::yield();
  EXPECT_EQ(client_->GetStats()->watchers, 0u);
  EXPECT_EQ(Host()->hub()->size(), 0u);
}

TEST_F(StreamTest, DeletingAMeshEndsItsWatchesAndEdits) {
  StartWithMesh();
  const auto watch = client_->Watch("m", {}, nullptr);
  ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
  const auto edits = client_->OpenEdits("m");
  ASSERT_TRUE(edits->Send({AddPoint(1)}).ok());
  ASSERT_TRUE(edits->Receive()->result.ok());
  ASSERT_TRUE(client_->DeleteMesh("m").ok());
  EXPECT_FALSE(watch->WaitForRevision(99, kLong));
  EXPECT_EQ(ReasonOf(*watch->ended()), codec::reason::kMeshDeleted);
  ASSERT_TRUE(edits->Send({AddPoint(2)}).ok());
  EXPECT_EQ(ReasonOf(edits->Receive()->result.status()), codec::reason::kMeshDeleted);
  // The name is free again, for another mesh.
  EXPECT_EQ(client_->CreateMesh("m", {})->revision, 0u);
}

TEST_F(StreamTest, AWatcherOfAServerThatLostItsMeshesIsToldSoAndKeepsWhatItHas) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  const MeshHash hash = HeadOf().hash;
  client::WatchOptions options;
  options.first_pause = absl::Milliseconds(5);
  options.longest_pause = absl::Milliseconds(50);
  options.max_attempts = 10'000;
  const auto watch = client_->Watch("m", options, nullptr);
  ASSERT_TRUE(watch->WaitForRevision(1, kLong));
  ServerConfig config;
  config.listen = server_->address();
  server_.reset();
  const auto next = Server::Start(config, [](const MeshOptions& o) { return MakeFake(o); });
  ASSERT_TRUE(next.ok()) << Text(next.status());
  EXPECT_FALSE(watch->WaitForRevision(2, kLong));
  ASSERT_TRUE(watch->ended().has_value());
  EXPECT_EQ(ReasonOf(*watch->ended()), codec::reason::kMeshNotFound);
  watch->Read([&](const client::MeshReplica& r) { EXPECT_EQ(r.hash(), hash); });
}

// ------------------------------------------------------------------ drain

TEST_F(StreamTest, ADrainEndsWhatRunsAndRefusesWhatIsNew) {
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
  while (Host()->waiting() < 1) std::this_thread::yield();

  Mailbox<bool> drained;
  std::thread drainer([&] { drained.Put(server_->Drain(kLong)); });
  while (Health("") != 2) std::this_thread::yield();
  EXPECT_EQ(Health("dynmesh.v1.MeshService"), 2);
  EXPECT_FALSE(watch->WaitForRevision(99, kLong));
  EXPECT_EQ(ReasonOf(*watch->ended()), codec::reason::kDraining);
  // The gate closes a moment after the health says so.
  absl::Status refused;
  do {
    refused = client_->CreateMesh("", {}).status();
  } while (refused.ok());
  EXPECT_EQ(refused.code(), StatusCode::kUnavailable);
  EXPECT_EQ(ReasonOf(refused), codec::reason::kDraining);
  EXPECT_TRUE(codec::GetServiceError(refused)->retry_after.has_value());
  EXPECT_EQ(ReasonOf(client_->Apply("m", {AddPoint(2)}).status()), codec::reason::kDraining);

  gate_->Release();
  const auto result = running.Take();
  ASSERT_TRUE(result.ok()) << Text(result.status());
  EXPECT_EQ(result->diff.to_revision, 2u);
  // What the stream had handed in is answered, then the stream ends.
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

TEST_F(StreamTest, ADrainThatTakesTooLongCancels) {
  StartWithMesh();
  gate_->Hold();
  const auto host = Host();
  Mailbox<absl::StatusOr<client::EditResult>> running;
  std::thread editor([&] { running.Put(client_->Apply("m", {AddPoint(1)})); });
  gate_->WaitForArrivals(1);
  EXPECT_FALSE(server_->Drain(absl::Milliseconds(20)));
  EXPECT_FALSE(running.Take().ok());
  EXPECT_EQ(host->head().revision, 0u);
  editor.join();
}

TEST_F(StreamTest, AServerEndsWithAllKindsOfStreamsOpen) {
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
}  // namespace dynmesh::server
