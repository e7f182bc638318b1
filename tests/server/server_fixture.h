// A server with fake meshes on a free loopback port, in this process.
#ifndef DYNMESH_TESTS_SERVER_SERVER_FIXTURE_H_
#define DYNMESH_TESTS_SERVER_SERVER_FIXTURE_H_

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "dynmesh/client/mesh_client.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "server/base/log.h"
#include "server/server.h"
#include "tests/server/fake_dynamic_mesh.h"
#include "tests/server/test_support.h"

namespace dynmesh::server {

inline constexpr absl::Duration kLong = absl::Seconds(30);

// Of a batch that has that request id.
inline client::EditParams Id(const std::string& id) {
  client::EditParams params;
  params.request_id = id;
  return params;
}

class ServerFixture : public ::testing::Test {
 protected:
  ServerFixture() { EXPECT_TRUE(SetLogLevel("error").ok()); }

  void StartServer(ServerConfig config = {}) {
    config.listen = "127.0.0.1:0";
    auto server = Server::Start(
        config,
        [gate = gate_](const MeshOptions& options, const ApplyOptions&) {
          return MakeFake(options, gate);
        },
        nullptr, builder_, page_);
    ASSERT_TRUE(server.ok()) << Text(server.status());
    server_ = *std::move(server);
    client_ = client::MeshClient::Connect(server_->address());
    stub_ = v1::MeshService::NewStub(Channel());
  }
  // Polls for up to 20 seconds.
  template <typename Condition>
  static bool Eventually(const Condition& condition) {
    for (int i = 0; i < 1000; ++i) {
      if (condition()) return true;
      absl::SleepFor(absl::Milliseconds(20));
    }
    return false;
  }

  void StartWithMesh(ServerConfig config = {}) {
    StartServer(std::move(config));
    ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  }
  std::shared_ptr<grpc::Channel> Channel() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel(server_ != nullptr ? server_->address() : address_,
                                     grpc::InsecureChannelCredentials(), arguments);
  }
  std::shared_ptr<MeshHost> Host(const char* name = "meshes/m") const {
    return *server_->registry().Find(name);
  }
  Head HeadOf(const char* name = "meshes/m") const { return Host(name)->head(); }

  // A unary call of any service, as bytes.
  std::string CallBytes(const std::string& method, const std::string& request,
                        grpc::Status* status) {
    grpc::GenericStub generic(Channel());
    grpc::ClientContext context;
    grpc::CompletionQueue queue;
    grpc::Slice slice(request);
    const grpc::ByteBuffer sent(&slice, 1);
    grpc::ByteBuffer received;
    auto call = generic.PrepareUnaryCall(&context, method, sent, &queue);
    call->StartCall();
    call->Finish(&received, status, this);
    void* tag = nullptr;
    bool ok = false;
    EXPECT_TRUE(queue.Next(&tag, &ok));
    grpc::Slice whole;
    if (received.Valid()) {
      EXPECT_TRUE(received.DumpToSingleSlice(&whole).ok());
    }
    return std::string(reinterpret_cast<const char*>(whole.begin()), whole.size());
  }
  // 1 SERVING, 2 NOT_SERVING, as grpc.health.v1 numbers them; 0 if the query fails.
  int Health(const std::string& service) {
    grpc::Status status;
    std::string request;
    if (!service.empty()) {
      request = std::string("\x0a") + static_cast<char>(service.size()) + service;
    }
    const std::string reply = CallBytes("/grpc.health.v1.Health/Check", request, &status);
    return status.ok() && reply.size() == 2 && reply[0] == 8 ? reply[1] : 0;
  }

  std::shared_ptr<FakeGate> gate_ = std::make_shared<FakeGate>();
  std::shared_ptr<FakeGate> build_gate_ = std::make_shared<FakeGate>();
  absl::Span<const StaticFile> page_;
  MeshBuilder builder_ = [gate = build_gate_](auto features, const auto& options,
                                              const auto& build) {
    return BuildFake(features, options, build, gate);
  };
  std::unique_ptr<Server> server_;
  std::string address_;  // while there is no server_
  std::unique_ptr<client::MeshClient> client_;
  std::unique_ptr<v1::MeshService::Stub> stub_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_SERVER_FIXTURE_H_
