// Calls that wait at a server that is alive for gRPC, but does not answer, as one that is stopped:
// whether they go to another server, and when they stay. What is tested is bound to questions that
// servers get, not to times.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/metadata.h"
#include "proto/codec/status_codec.h"
#include "tests/support/deadline.h"

namespace dynmesh::client::waiting_calls_test {
namespace {

using Context = grpc::ServerContext;

// A call that a question comes with was sent on twice already; others come by themselves.
bool IsQuestion(const Context& context) {
  const auto it = context.client_metadata().find(codec::kRedirectsKey);
  return it != context.client_metadata().end() && it->second == "2";
}

grpc::Status NotOwner(const std::string& owner) {
  codec::ServiceError error;
  error.reason = codec::reason::kNotOwner;
  error.metadata["owner"] = owner;
  return codec::ToGrpcStatus(
      codec::MakeServiceError(absl::StatusCode::kUnavailable, "not here", error));
}

// A server whose answers a test decides. At first it has all meshes.
class DecidedServer final : public v1::MeshService::Service {
 public:
  DecidedServer() {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~DecidedServer() override {
    is_silent = gives_signs = false;
    server_->Shutdown(std::chrono::system_clock::now());
  }

  // Does not answer, for as long as this is true or until the client leaves.
  std::atomic<bool> is_silent{false};
  // Answers to GetStats; an idle stream asks for them.
  std::atomic<bool> gives_signs{true};
  // What it says about meshes, once it answers.
  std::function<grpc::Status()> says = [] { return grpc::Status::OK; };

  std::atomic<int> calls{0}, questions{0}, signs{0}, left{0};  // left: by the client, unanswered

  grpc::Status GetMesh(Context* context, const v1::GetMeshRequest* request,
                       v1::Mesh* response) override {
    response->set_name(request->mesh());
    response->set_revision(static_cast<std::uint64_t>(port_));
    return Answer(*context);
  }
  grpc::Status ApplyEdits(Context* context, const v1::ApplyEditsRequest* /*request*/,
                          grpc::ServerWriter<v1::MeshDiff>* /*writer*/) override {
    const grpc::Status status = Answer(*context);
    return status.ok() ? grpc::Status(grpc::StatusCode::NOT_FOUND, address()) : status;
  }
  grpc::Status EditStream(Context* context,
                          grpc::ServerReaderWriter<v1::MeshDiff, v1::EditBatch>* edits) override {
    v1::EditBatch batch;
    while (edits->Read(&batch)) {
      if (grpc::Status status = Answer(*context); !status.ok()) return status;
    }
    return grpc::Status(grpc::StatusCode::NOT_FOUND, address());
  }
  grpc::Status Watch(Context* context, const v1::WatchRequest* /*request*/,
                     grpc::ServerWriter<v1::WatchEvent>* /*writer*/) override {
    ++calls;
    test::WaitUntil("the client's end", [&] { return context->IsCancelled(); });
    ++left;
    return grpc::Status::OK;
  }
  grpc::Status ListMeshes(Context* context, const v1::ListMeshesRequest* /*request*/,
                          v1::ListMeshesResponse* /*response*/) override {
    return Answer(*context);
  }
  grpc::Status GetStats(Context* context, const v1::GetStatsRequest* /*request*/,
                        v1::GetStatsResponse* /*response*/) override {
    ++signs;
    if (!gives_signs) Leave(*context, [&] { return gives_signs.load(); });
    return grpc::Status::OK;
  }

  std::string address() const { return absl::StrCat("127.0.0.1:", port_); }
  std::uint64_t mark() const { return static_cast<std::uint64_t>(port_); }

 private:
  // Until the client leaves, or `or_else`.
  template <class OrElse>
  static bool Leave(const Context& context, const OrElse& or_else) {
    test::WaitUntil("the client's end", [&] { return context.IsCancelled() || or_else(); });
    return context.IsCancelled();
  }
  grpc::Status Answer(const Context& context) {
    ++(IsQuestion(context) ? questions : calls);
    if (is_silent && Leave(context, [&] { return !is_silent; })) {
      ++left;
      return grpc::Status::CANCELLED;
    }
    return says();
  }

  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

class WaitingCallsTest : public ::testing::Test {
 protected:
  WaitingCallsTest() { silent_.is_silent = true; }

  // Knows the silent server first.
  std::unique_ptr<MeshClient> Connect(bool from_followers = false) const {
    ClientOptions options;
    options.own_connection = true;
    options.from_followers = from_followers;
    return MeshClient::Connect(absl::StrCat(silent_.address(), ",", other_.address()), options);
  }

  DecidedServer silent_, other_;
};

TEST_F(WaitingCallsTest, ACallGoesToTheServerThatHasTheMeshByNow) {
  const auto client = Connect();
  const auto mesh = client->GetMesh("m");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->revision, other_.mark());
  EXPECT_EQ(silent_.calls, 1);
  // So do later ones, at once.
  EXPECT_TRUE(client->GetMesh("m").ok());
  EXPECT_EQ(silent_.calls, 1);
}

TEST_F(WaitingCallsTest, AChangeDoesIfItHasARequestId) {
  const auto client = Connect();
  // This one has none, and waits.
  std::thread waits([&] {
    EXPECT_EQ(client->Apply("m", {Edit::Remove(1)}).status().message(), silent_.address());
  });
  test::WaitUntil("its call", [&] { return silent_.calls == 1; });
  EditParams params;
  params.request_id = "r";
  const auto result = client->Apply("m", {Edit::Remove(1)}, params);
  EXPECT_EQ(result.status().message(), other_.address());
  EXPECT_EQ(silent_.calls, 2);
  EXPECT_EQ(silent_.left, 1);
  silent_.is_silent = false;
  waits.join();
}

TEST_F(WaitingCallsTest, ASlowOwnerKeepsItsCalls) {
  other_.says = [&] { return NotOwner(silent_.address()); };
  const auto client = Connect();
  std::thread answers([&] {
    test::WaitUntil("questions", [&] { return other_.questions >= 3; });
    silent_.is_silent = false;
  });
  const auto mesh = client->GetMesh("m");
  answers.join();
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->revision, silent_.mark());
  EXPECT_EQ(silent_.calls, 1);
  EXPECT_EQ(other_.calls, 0);
}

TEST_F(WaitingCallsTest, AThirdServerThatHasTheMeshIsAskedBeforeACallGoesThere) {
  DecidedServer third;
  other_.says = [&] { return NotOwner(third.address()); };
  const auto client = MeshClient::Connect(
      absl::StrCat(silent_.address(), ",", other_.address(), ",", third.address()));
  third.is_silent = true;
  std::thread answers([&] {
    // It would be the same server that the call waits at, or another that is stopped.
    test::WaitUntil("a question that is not answered", [&] { return third.left >= 1; });
    EXPECT_EQ(third.calls, 0);
    third.is_silent = false;
  });
  const auto mesh = client->GetMesh("m");
  answers.join();
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->revision, third.mark());
  EXPECT_EQ(silent_.calls, 1);
}

TEST_F(WaitingCallsTest, AnEditSessionEndsIfAnAnswerDoesNotCome) {
  const auto client = Connect();
  // Finds the mesh at the silent server, which then falls silent.
  silent_.is_silent = false;
  const auto session = client->OpenEdits("m");
  silent_.is_silent = true;
  ASSERT_TRUE(session->Send({Edit::Remove(1)}, {}).ok());
  EXPECT_FALSE(session->Receive().has_value());
  EXPECT_TRUE(absl::IsUnavailable(session->Finish()));
  // The next one goes to the other server.
  const auto next = client->OpenEdits("m");
  ASSERT_TRUE(next->DoneSending().ok());
  EXPECT_FALSE(next->Receive().has_value());
  EXPECT_EQ(next->Finish().message(), other_.address());
}

TEST_F(WaitingCallsTest, AWatchStaysAtAServerThatGivesSigns) {
  const auto client = Connect();
  const auto watch = client->Watch("m", {}, nullptr);
  test::WaitUntil("signs", [&] { return silent_.signs >= 2; });
  EXPECT_EQ(watch->reconnects(), 0);
  EXPECT_EQ(other_.questions, 0);
}

TEST_F(WaitingCallsTest, AWatchOfAServerWithoutSignsGoesToTheOneThatHasTheMesh) {
  silent_.gives_signs = false;
  const auto client = Connect();
  const auto watch = client->Watch("m", {}, nullptr);
  test::WaitUntil("the watch elsewhere", [&] { return other_.calls == 1; });
  EXPECT_EQ(silent_.calls, 1);
  EXPECT_EQ(watch->reconnects(), 1);
}

TEST_F(WaitingCallsTest, AWatchOfASlowOwnerStays) {
  silent_.gives_signs = false;
  other_.says = [&] { return NotOwner(silent_.address()); };
  const auto client = Connect();
  const auto watch = client->Watch("m", {}, nullptr);
  test::WaitUntil("questions", [&] { return other_.questions >= 2; });
  silent_.gives_signs = true;
  const int asked = silent_.signs;
  test::WaitUntil("a sign", [&] { return silent_.signs > asked; });
  EXPECT_EQ(watch->reconnects(), 0);
  EXPECT_EQ(silent_.calls, 1);
}

TEST_F(WaitingCallsTest, AFollowersWatchGoesToAnyServer) {
  silent_.gives_signs = false;
  const auto client = Connect(/*from_followers=*/true);
  const auto watch = client->Watch("m", {}, nullptr);
  test::WaitUntil("the watch elsewhere", [&] { return other_.calls == 1; });
  EXPECT_EQ(other_.questions, 0);
}

TEST_F(WaitingCallsTest, ACallThatAnyServerCanAnswerLeavesOneWithoutSigns) {
  silent_.gives_signs = false;
  const auto client = Connect();
  EXPECT_TRUE(client->ListMeshes().ok());
  EXPECT_EQ(silent_.left, 1);
  EXPECT_EQ(other_.calls, 1);
}

TEST_F(WaitingCallsTest, ItStaysAtOneThatGivesSigns) {
  const auto client = Connect();
  std::thread answers([&] {
    test::WaitUntil("signs", [&] { return silent_.signs >= 2; });
    silent_.is_silent = false;
  });
  EXPECT_TRUE(client->ListMeshes().ok());
  answers.join();
  EXPECT_EQ(silent_.left, 0);
  EXPECT_EQ(other_.calls, 0);
}

TEST_F(WaitingCallsTest, AClientThatGoesWaitsForNoQuestion) {
  other_.is_silent = true;
  const auto client = Connect();
  std::thread answers([&] {
    test::WaitUntil("a question", [&] { return other_.questions >= 1; });
    silent_.is_silent = false;
  });
  EXPECT_TRUE(client->GetMesh("m").ok());
  answers.join();
}

}  // namespace
}  // namespace dynmesh::client::waiting_calls_test
