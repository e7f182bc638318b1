// Clients whose server ends and comes back at the same address. gRPC's own look at connections that
// no call waits for, every five seconds, is switched off: what is tested does not rest on it. Nor
// on the threads of the server, which is in this process: they look at its own connections only.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "tests/server/test_support.h"
#include "tests/support/deadline.h"
#include "tests/support/held_port.h"

namespace dynmesh::client::reconnect_test {
namespace {

using server::Mailbox;

// Before gRPC begins.
const int switched_off = setenv("GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS", "0", 1) +
                         setenv("GRPC_POLL_STRATEGY", "poll", 1);

// Knows no mesh, while it is up.
class ReturningServer final : public v1::MeshService::Service {
 public:
  ReturningServer() { Start(); }
  ~ReturningServer() override { End(); }

  void Start() {
    grpc::ServerBuilder builder;
    builder.AddListeningPort(port_.address(), grpc::InsecureServerCredentials());
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
    ASSERT_NE(server_, nullptr);
  }
  void End() {
    if (server_ != nullptr) server_->Shutdown(std::chrono::system_clock::now());
    server_ = nullptr;
  }

  grpc::Status GetMesh(grpc::ServerContext* /*context*/, const v1::GetMeshRequest* /*request*/,
                       v1::Mesh* /*response*/) override {
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "no mesh");
  }
  grpc::Status Watch(grpc::ServerContext* context, const v1::WatchRequest* /*request*/,
                     grpc::ServerWriter<v1::WatchEvent>* /*writer*/) override {
    ++watches_;
    test::WaitUntil("the client's end", [&] { return context->IsCancelled(); });
    return grpc::Status::OK;
  }

  const std::string& address() const { return port_.address(); }
  int watches() const { return watches_; }

 private:
  const test::HeldPort port_;
  std::atomic<int> watches_{0};
  std::unique_ptr<grpc::Server> server_;
};

std::unique_ptr<MeshClient> Connect(const std::string& address,
                                    absl::Duration timeout = absl::InfiniteDuration()) {
  ClientOptions options;
  options.timeout = timeout;
  options.own_connection = true;
  return MeshClient::Connect(address, options);
}

// Until a server answers.
void AwaitAnswer(MeshClient& client) {
  test::WaitUntil("an answer", [&] { return absl::IsNotFound(client.GetMesh("m").status()); });
}

TEST(Reconnect, ACallThatIsRepeatedSucceedsAfterTheServersReturn) {
  ReturningServer server;
  const auto client = Connect(server.address());
  AwaitAnswer(*client);
  for (int i = 0; i < 3; ++i) {
    server.End();
    // The connection is lost, the next attempt to connect fails, and so do later ones.
    for (int failures = 0; failures < 5 * (1 + 10 * i); ++failures) {
      EXPECT_TRUE(absl::IsUnavailable(client->GetMesh("m").status()));
    }
    server.Start();
    AwaitAnswer(*client);
  }
}

TEST(Reconnect, SoDoAHundredCallsAtOnce) {
  ReturningServer server;
  const auto client = Connect(server.address());
  AwaitAnswer(*client);
  server.End();
  std::atomic<int> failed{0}, answered{0};
  std::vector<std::thread> callers;
  for (int i = 0; i < 100; ++i) {
    callers.emplace_back([&] {
      while (!absl::IsUnavailable(client->GetMesh("m").status())) {
      }
      ++failed;
      AwaitAnswer(*client);
      ++answered;
    });
  }
  test::WaitUntil("failures of all", [&] { return failed == 100; });
  server.Start();
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(answered, 100);
}

TEST(Reconnect, APauseBeforeARetryEndsWithTheServersReturn) {
  ReturningServer server;
  const auto client = Connect(server.address());
  server.End();
  EXPECT_TRUE(absl::IsUnavailable(client->GetMesh("m").status()));
  EXPECT_EQ(client->servers_returned(), 0U);
  std::thread returns([&] { server.Start(); });
  // As long as this test may take: what it returns before is the server's return.
  client->PauseBeforeRetry(absl::InfiniteDuration());
  EXPECT_EQ(client->servers_returned(), 1U);
  EXPECT_TRUE(absl::IsNotFound(client->GetMesh("m").status()));
  returns.join();
}

struct Troubled : WatchListener {
  void OnTrouble(const absl::Status&) override { trouble.Put(0); }
  Mailbox<int> trouble;
};

TEST(Reconnect, AWatchThatPausesGoesOnWithTheServersReturn) {
  ReturningServer server;
  const auto client = Connect(server.address());
  server.End();
  Troubled troubled;
  WatchOptions options;
  options.first_pause = options.longest_pause = absl::Hours(1);
  const auto watch = client->Watch("m", options, &troubled);
  troubled.trouble.Take();
  server.Start();
  test::WaitUntil("the watch", [&] { return server.watches() == 1; });
}

TEST(Reconnect, ADiffStreamThatPausesGoesOnWithTheServersReturn) {
  ReturningServer server;
  const auto client = Connect(server.address());
  server.End();
  const auto stream = client->StreamDiffs("m", {});
  EXPECT_TRUE(absl::IsUnavailable(client->GetMesh("m").status()));
  server.Start();
  test::WaitUntil("the watch", [&] { return server.watches() == 1; });
}

TEST(Reconnect, OneOfManyServersIsEnough) {
  ReturningServer first, second, third;
  const auto client =
      Connect(absl::StrCat(first.address(), ",", second.address(), ",", third.address()),
              absl::Milliseconds(300));
  AwaitAnswer(*client);
  for (ReturningServer* server : {&first, &second, &third}) server->End();
  EXPECT_FALSE(absl::IsNotFound(client->GetMesh("m").status()));
  third.Start();
  AwaitAnswer(*client);
}

TEST(Reconnect, AClientThatGoesWaitsForNoServer) {
  ReturningServer server;
  server.End();
  for (int i = 0; i < 10; ++i) {
    const auto client = Connect(server.address());
    EXPECT_TRUE(absl::IsUnavailable(client->GetMesh("m").status()));
    if (i % 2 == 0) client->PauseBeforeRetry(absl::Milliseconds(30 * i));
  }
}

}  // namespace
}  // namespace dynmesh::client::reconnect_test
