// Nodes with TLS hand calls on to each other, for clients that do not go there themselves.
#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"
#include "tests/cluster/cluster_fixture.h"
#include "tests/support/certificates.h"

namespace dynmesh::test {
namespace {

// Both nodes have the certificate "node", and ask for those of their clients.
class TlsForwardingTest : public ClusterTest {
 protected:
  TlsForwardingTest() : ClusterTest("3600") {
    certificates_.MakeAuthority("authority");
    certificates_.MakeAuthority("another");
    for (const char* name : {"node", "client"}) certificates_.Make(name, "authority");
  }

  // `more`: flags of both nodes.
  void StartBoth(std::vector<std::string> more) {
    for (const auto& [flag, file] : {std::pair{"--tls-cert", "node.pem"},
                                     {"--tls-key", "node.key"},
                                     {"--tls-client-ca", "authority.pem"}}) {
      more.insert(more.end(), {flag, certificates_.Path(file)});
    }
    StartNodes(2, more);
    client::ClientOptions options;
    options.own_connection = true;
    options.tls_ca = certificates_.Certificate("authority");
    options.tls_certificate = certificates_.Certificate("client");
    options.tls_key = certificates_.Key("client");
    owner_ = MeshClient::Connect(nodes_[0]->address, options);
    const auto made = owner_->CreateMesh("m", MeshOptions());
    ASSERT_TRUE(made.ok()) << made.status();
    service_ = v1::MeshService::NewStub(grpc::CreateChannel(
        nodes_[1]->address,
        grpc::SslCredentials({options.tls_ca, options.tls_key, options.tls_certificate})));
  }
  // What a client of the other node, that says nothing of redirects, is told.
  absl::StatusOr<std::uint64_t> RevisionByTheOtherNode() {
    v1::GetMeshRequest request;
    request.set_mesh("meshes/m");
    v1::Mesh mesh;
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kPatience);
    const absl::Status status = codec::FromGrpcStatus(service_->GetMesh(&context, request, &mesh));
    if (!status.ok()) return status;
    return mesh.revision();
  }

  Certificates certificates_;
  std::unique_ptr<MeshClient> owner_;
  std::unique_ptr<v1::MeshService::Stub> service_;
};

TEST_F(TlsForwardingTest, WithTheirAuthorityCallsAreHandedOn) {
  ASSERT_NO_FATAL_FAILURE(StartBoth({"--node-ca", certificates_.Path("authority.pem")}));
  EXPECT_EQ(*RevisionByTheOtherNode(), 0u);
  ASSERT_TRUE(owner_->Apply("m", {Edit::Add(Feature::Point(1, 0.3, 0.4))}).ok());
  EXPECT_EQ(*RevisionByTheOtherNode(), 1u);
}

TEST_F(TlsForwardingTest, WithoutItTheClientGetsTheOwnersAddress) {
  ASSERT_NO_FATAL_FAILURE(StartBoth({}));
  const auto error = codec::GetServiceError(RevisionByTheOtherNode().status());
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->reason, codec::reason::kNotOwner);
}

// The owner's certificate is not of that authority: the node does not talk to it.
TEST_F(TlsForwardingTest, WithAnotherAuthorityNoCallIsHandedOn) {
  ASSERT_NO_FATAL_FAILURE(StartBoth({"--node-ca", certificates_.Path("another.pem")}));
  EXPECT_TRUE(absl::IsUnavailable(RevisionByTheOtherNode().status()));
}

}  // namespace
}  // namespace dynmesh::test
