// Calls that a server cancels because it shuts down: the client did not, so the server is not
// available, and another one is asked. And calls to a server that is cut off from its database.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"
#include "tests/support/deadline.h"

namespace dynmesh::client::cut_off_calls_test {
namespace {

// Cancels the first calls, or ends them with `how`. Then it says that there is no mesh.
class CuttingServer final : public v1::MeshService::Service {
 public:
  explicit CuttingServer(int cut, grpc::Status how = grpc::Status::CANCELLED)
      : left_(cut), how_(std::move(how)) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~CuttingServer() override { server_->Shutdown(std::chrono::system_clock::now()); }

  grpc::Status GetMesh(grpc::ServerContext* /*context*/, const v1::GetMeshRequest* request,
                       v1::Mesh* /*response*/) override {
    if (IsCut()) return how_;
    return grpc::Status(grpc::StatusCode::NOT_FOUND, absl::StrCat("no ", request->mesh()));
  }
  grpc::Status EditStream(grpc::ServerContext* context,
                          grpc::ServerReaderWriter<v1::MeshDiff, v1::EditBatch>* edits) override {
    v1::EditBatch batch;
    if (IsCut()) return grpc::Status::CANCELLED;
    while (!context->IsCancelled() && edits->Read(&batch)) {
    }
    return grpc::Status::CANCELLED;
  }
  grpc::Status Watch(grpc::ServerContext* /*context*/, const v1::WatchRequest* /*request*/,
                     grpc::ServerWriter<v1::WatchEvent>* /*writer*/) override {
    if (IsCut()) return grpc::Status::CANCELLED;
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "no mesh");
  }

  std::string address() const { return absl::StrCat("127.0.0.1:", port_); }
  int calls() const { return calls_; }

 private:
  bool IsCut() {
    ++calls_;
    return left_-- > 0;
  }

  std::atomic<int> left_, calls_{0};
  const grpc::Status how_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

TEST(CutOffCalls, AnotherServerIsAsked) {
  CuttingServer first(1), second(0);
  const auto client = MeshClient::Connect(absl::StrCat(first.address(), ",", second.address()));
  const absl::Status found = client->GetMesh("m").status();
  EXPECT_TRUE(absl::IsNotFound(found)) << found;
  EXPECT_EQ(first.calls(), 1);
  EXPECT_EQ(second.calls(), 1);
}

grpc::Status Unavailable(const char* reason) {
  codec::ServiceError error;
  error.reason = reason;
  return codec::ToGrpcStatus(
      codec::MakeServiceError(absl::StatusCode::kUnavailable, "try again", error));
}

TEST(CutOffCalls, AnotherServerMayKnowTheOwnerOrTheOutcome) {
  for (const char* reason : {codec::reason::kNotOwner, codec::reason::kOutcomeUnknown}) {
    SCOPED_TRACE(reason);
    CuttingServer first(1000, Unavailable(reason)), second(0);
    const auto client = MeshClient::Connect(absl::StrCat(first.address(), ",", second.address()));
    for (int i = 0; i < 2; ++i) {
      const absl::Status found = client->GetMesh("m").status();
      EXPECT_TRUE(absl::IsNotFound(found)) << found;
    }
    EXPECT_EQ(first.calls(), 1);
    EXPECT_EQ(second.calls(), 2);
  }
}

TEST(CutOffCalls, AfterAFailureOfTheJournalTheNextCallAsksAnotherServer) {
  CuttingServer first(1000, Unavailable(codec::reason::kJournalFailed)), second(0);
  const auto client = MeshClient::Connect(absl::StrCat(first.address(), ",", second.address()));
  const absl::Status failed = client->GetMesh("m").status();
  EXPECT_EQ(codec::GetServiceError(failed)->reason, codec::reason::kJournalFailed) << failed;
  EXPECT_TRUE(absl::IsNotFound(client->GetMesh("m").status()));
  EXPECT_EQ(first.calls(), 1);
}

TEST(CutOffCalls, TheOnlyServerIsUnavailable) {
  CuttingServer server(1000);
  const auto client = MeshClient::Connect(server.address());
  EXPECT_TRUE(absl::IsUnavailable(client->GetMesh("m").status()));
  EXPECT_TRUE(absl::IsUnavailable(client->OpenEdits("m", true)->Finish()));
}

TEST(CutOffCalls, AnEditSessionThatIsCancelledHereSaysSo) {
  CuttingServer server(0);
  const auto client = MeshClient::Connect(server.address());
  const auto session = client->OpenEdits("m", true);
  session->Cancel();
  EXPECT_TRUE(absl::IsCancelled(session->Finish()));
}

TEST(CutOffCalls, AWatchGoesOn) {
  CuttingServer server(2);
  const auto client = MeshClient::Connect(server.address());
  WatchOptions options;
  options.first_pause = absl::Milliseconds(1);
  const auto session = client->Watch("m", options, nullptr);
  test::WaitUntil("the end of the watch", [&] { return session->ended().has_value(); });
  EXPECT_TRUE(absl::IsNotFound(*session->ended())) << *session->ended();
  EXPECT_EQ(session->reconnects(), 2);
}

}  // namespace
}  // namespace dynmesh::client::cut_off_calls_test
