// The watch session against a server that follows a script: its requests after invalid data, a
// broken connection, a refusal.
#include "dynmesh/client/watch_session.h"

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "dynmesh/client/mesh_client.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "tests/server/fake_dynamic_mesh.h"
#include "tests/server/test_support.h"
#include "tests/support/deadline.h"

namespace dynmesh::client::watch_session_test {
namespace {

using server::AddPoint;
using server::FakeDynamicMesh;
using server::Mailbox;

constexpr absl::Duration kLong = absl::Seconds(30);

// Answers the n-th Watch with the n-th act.
class ScriptedServer final : public v1::MeshService::Service {
 public:
  using Writer = grpc::ServerWriter<v1::WatchEvent>;
  using Act = std::function<grpc::Status(grpc::ServerContext&, Writer&)>;

  explicit ScriptedServer(std::vector<Act> acts) : acts_(std::move(acts)) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~ScriptedServer() override { server_->Shutdown(std::chrono::system_clock::now()); }

  grpc::Status Watch(grpc::ServerContext* context, const v1::WatchRequest* request,
                     Writer* writer) override {
    std::size_t n = 0;
    {
      const std::lock_guard lock(mutex_);
      n = requests_.size();
      requests_.push_back(*request);
    }
    if (n >= acts_.size()) return grpc::Status(grpc::StatusCode::NOT_FOUND, "the play is over");
    return acts_[n](*context, *writer);
  }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  std::vector<v1::WatchRequest> requests() {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

 private:
  const std::vector<Act> acts_;
  int port_ = 0;
  std::mutex mutex_;
  std::vector<v1::WatchRequest> requests_;
  std::unique_ptr<grpc::Server> server_;
};

class WatchSessionTest : public ::testing::Test {
 protected:
  WatchSessionTest() {
    meshes_.push_back(fake_.Snapshot());
    for (FeatureId id = 1; id <= 5; ++id) {
      diffs_.push_back(*fake_.Apply({AddPoint(id)}, {}));
      meshes_.push_back(fake_.Snapshot());
    }
    options_.first_pause = absl::Milliseconds(1);
    options_.longest_pause = absl::Milliseconds(5);
  }

  static void Send(ScriptedServer::Writer& writer, const Mesh& mesh) {
    codec::SnapshotFragmenter fragmenter(std::make_shared<Mesh>(mesh), 100);
    v1::WatchEvent event;
    while (fragmenter.Next(event.mutable_snapshot())) writer.Write(event);
  }
  static void Send(ScriptedServer::Writer& writer, const MeshDiff& diff) {
    codec::DiffFragmenter fragmenter(std::make_shared<MeshDiff>(diff), false, 100);
    v1::WatchEvent event;
    while (fragmenter.Next(event.mutable_diff())) writer.Write(event);
  }
  // Until the client leaves.
  static grpc::Status Stay(grpc::ServerContext& context) {
    test::WaitUntil("the client's end", [&] { return context.IsCancelled(); });
    return grpc::Status::OK;
  }
  static grpc::Status Down() { return grpc::Status(grpc::StatusCode::UNAVAILABLE, "down"); }

  FakeDynamicMesh fake_{MeshOptions(), nullptr};
  std::vector<Mesh> meshes_;     // by revision
  std::vector<MeshDiff> diffs_;  // diffs_[i] leaves revision i
  WatchOptions options_;
};

TEST_F(WatchSessionTest, TakesASnapshotAfterALostDiff) {
  ScriptedServer script({[&](auto& context, auto& writer) {
                           Send(writer, meshes_[0]);
                           Send(writer, diffs_[0]);
                           Send(writer, diffs_[2]);
                           return Stay(context);
                         },
                         [&](auto& context, auto& writer) {
                           Send(writer, meshes_[4]);
                           Send(writer, diffs_[4]);
                           return Stay(context);
                         }});
  const auto client = MeshClient::Connect(script.address());
  const auto session = client->Watch("m", options_, nullptr);
  ASSERT_TRUE(session->WaitForRevision(5, kLong));
  session->Read([&](const MeshReplica& r) { EXPECT_EQ(r.hash(), fake_.hash()); });
  EXPECT_EQ(session->resyncs(), 1);
  const auto requests = script.requests();
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_FALSE(requests[0].has_start_revision());
  EXPECT_FALSE(requests[1].has_start_revision());
}

TEST_F(WatchSessionTest, ResumesWhereItWasAfterABrokenConnection) {
  ScriptedServer script({[&](auto&, auto& writer) {
                           Send(writer, meshes_[0]);
                           Send(writer, diffs_[0]);
                           Send(writer, diffs_[1]);
                           return Down();
                         },
                         [&](auto&, auto&) { return Down(); },
                         [&](auto& context, auto& writer) {
                           for (int i = 2; i < 5; ++i) Send(writer, diffs_[i]);
                           return Stay(context);
                         }});
  const auto client = MeshClient::Connect(script.address());
  const auto session = client->Watch("m", options_, nullptr);
  ASSERT_TRUE(session->WaitForRevision(5, kLong));
  EXPECT_EQ(session->resyncs(), 0);
  EXPECT_EQ(session->reconnects(), 2);
  const auto requests = script.requests();
  ASSERT_EQ(requests.size(), 3u);
  for (int i : {1, 2}) {
    EXPECT_EQ(requests[i].start_revision(), 2u);
    EXPECT_EQ(requests[i].start_hash(), meshes_[2].hash.ToHex());
  }
}

TEST_F(WatchSessionTest, TakesASnapshotWhenItsRevisionIsCompactedOrAnother) {
  ScriptedServer script({[&](auto&, auto& writer) {
                           Send(writer, meshes_[1]);
                           return Down();
                         },
                         [&](auto&, auto&) {
                           codec::ServiceError error;
                           error.reason = codec::reason::kCompacted;
                           return codec::ToGrpcStatus(codec::MakeServiceError(
                               absl::StatusCode::kOutOfRange, "compacted", error));
                         },
                         [&](auto& context, auto& writer) {
                           Send(writer, meshes_[5]);
                           return Stay(context);
                         }});
  const auto client = MeshClient::Connect(script.address());
  const auto session = client->Watch("m", options_, nullptr);
  ASSERT_TRUE(session->WaitForRevision(5, kLong));
  const auto requests = script.requests();
  ASSERT_EQ(requests.size(), 3u);
  EXPECT_TRUE(requests[1].has_start_revision());
  EXPECT_FALSE(requests[2].has_start_revision());
}

class Recorder : public WatchListener {
 public:
  void OnSnapshot(const MeshReplica& r) override { Add("snapshot", r); }
  void OnDiff(const MeshReplica& r, const MeshDiff&) override { Add("diff", r); }
  void OnProgress(const MeshReplica& r) override { Add("progress", r); }
  void OnTrouble(const absl::Status& s) override {
    lines.push_back(absl::StrCat("trouble ", absl::StatusCodeToString(s.code())));
  }
  void OnEnd(const absl::Status& s) override {
    lines.push_back(absl::StrCat("end ", absl::StatusCodeToString(s.code())));
    ended.Put(0);
  }
  std::vector<std::string> lines;
  Mailbox<int> ended;

 private:
  void Add(const char* what, const MeshReplica& r) {
    lines.push_back(absl::StrCat(what, " ", r.revision()));
  }
};

TEST_F(WatchSessionTest, TellsItsListenerEverythingInOrder) {
  ScriptedServer script({[&](auto&, auto& writer) {
    Send(writer, meshes_[0]);
    Send(writer, diffs_[0]);
    v1::WatchEvent progress;
    progress.mutable_progress()->set_revision(1);
    progress.mutable_progress()->set_hash(diffs_[0].hash.ToHex());
    writer.Write(progress);
    Send(writer, diffs_[0]);  // again: invalid
    return Down();
  }});
  Recorder recorder;
  const auto client = MeshClient::Connect(script.address());
  const auto session = client->Watch("m", options_, &recorder);
  recorder.ended.Take();
  EXPECT_EQ(recorder.lines,
            (std::vector<std::string>{"snapshot 0", "diff 1", "progress 1",
                                      "trouble FAILED_PRECONDITION", "end NOT_FOUND"}));
  EXPECT_EQ(session->ended()->code(), absl::StatusCode::kNotFound);
}

TEST_F(WatchSessionTest, RevisionZeroIsThereWithTheFirstSnapshot) {
  Mailbox<int> go;
  ScriptedServer script({[&](auto& context, auto& writer) {
    go.Take();
    Send(writer, meshes_[0]);
    return Stay(context);
  }});
  const auto client = MeshClient::Connect(script.address());
  const auto session = client->Watch("m", options_, nullptr);
  EXPECT_FALSE(session->WaitForRevision(0, absl::Milliseconds(1)));
  go.Put(0);
  ASSERT_TRUE(session->WaitForRevision(0, absl::InfiniteDuration()));
  session->Read([&](const MeshReplica& r) {
    EXPECT_TRUE(r.has_mesh());
    EXPECT_EQ(r.hash(), meshes_[0].hash);
    EXPECT_EQ(r.vertex_count(), meshes_[0].vertices.ids.size());
  });
}

TEST_F(WatchSessionTest, GivesUpAfterSoManyAttempts) {
  options_.max_attempts = 3;
  ScriptedServer script(std::vector<ScriptedServer::Act>(100, [](auto&, auto&) { return Down(); }));
  const auto client = MeshClient::Connect(script.address());
  const auto session = client->Watch("m", options_, nullptr);
  EXPECT_FALSE(session->WaitForRevision(1, kLong));
  EXPECT_EQ(session->ended()->code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(script.requests().size(), 4u);
}

TEST_F(WatchSessionTest, StopsInEveryState) {
  options_.first_pause = absl::Seconds(1000);
  options_.longest_pause = absl::Seconds(1000);
  ScriptedServer script({[&](auto& context, auto& writer) {
                           Send(writer, meshes_[0]);
                           return Stay(context);
                         },
                         [&](auto&, auto&) { return Down(); }});
  const auto client = MeshClient::Connect(script.address());
  {
    const auto open = client->Watch("m", options_, nullptr);
    ASSERT_TRUE(open->WaitFor([](const MeshReplica& r) { return r.has_mesh(); }, kLong));
    open->Stop();
    EXPECT_EQ(open->ended()->code(), absl::StatusCode::kCancelled);
    open->Stop();  // a second Stop has no effect
  }
  struct Waiter : WatchListener {
    void OnTrouble(const absl::Status&) override { trouble.Put(0); }
    Mailbox<int> trouble;
  } waiter;
  const auto pausing = client->Watch("m", options_, &waiter);
  waiter.trouble.Take();
  pausing->Stop();
  EXPECT_EQ(pausing->ended()->code(), absl::StatusCode::kCancelled);
  // Destroyed at once, in any state.
  for (int i = 0; i < 20; ++i) client->Watch("m", options_, nullptr);
}

}  // namespace
}  // namespace dynmesh::client::watch_session_test
