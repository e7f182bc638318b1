// Which of several nodes has a mesh, and how clients get there. A lease is long, or ended by hand:
// no test measures time.
#include <grpcpp/grpcpp.h>

#include <fstream>
#include <thread>

#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "tests/cluster/cluster_fixture.h"
#include "tests/e2e/killed_clients.h"
#include "tests/e2e/run_dynmesh.h"
#include "tests/server/http/http_get.h"

namespace dynmesh::test {
namespace {

class OwnershipTest : public ClusterTest {
 protected:
  OwnershipTest() : ClusterTest("3600") {}

  static EditBatch Point(FeatureId id) {
    return {Edit::Add(Feature::Point(id, 0.01 * static_cast<double>(id), 0.5))};
  }
  static client::EditParams Request(const std::string& id) {
    client::EditParams params;
    params.request_id = id;
    return params;
  }
  std::unique_ptr<MeshClient> ConnectTo(int node) const {
    return Connect(nodes_[static_cast<std::size_t>(node)]->address);
  }
  const std::string& AddressOf(int node) const {
    return nodes_[static_cast<std::size_t>(node)]->address;
  }
  // As if the node had not renewed for longer than a lease.
  void EndLeasesOf(int node) {
    Sql("UPDATE dynmesh.meshes SET lease_until = clock_timestamp() - interval '1 second'");
    Sql("UPDATE dynmesh.nodes SET seen = seen - interval '2 hours' WHERE address = '" +
        AddressOf(node) + "'");
  }
};

TEST_F(OwnershipTest, AClientOfAnyNodeIsSentToTheOwner) {
  StartNodes(2);
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("m", MeshOptions()).ok());
  EXPECT_EQ(OwnerOf("m"), AddressOf(0));
  const auto other = ConnectTo(1);
  const auto applied = other->Apply("m", Point(1));
  ASSERT_TRUE(applied.ok()) << applied.status();
  EXPECT_EQ(applied->diff.to_revision, 1u);
  const auto session = ConnectTo(1)->OpenEdits("m");
  EXPECT_EQ(ConnectTo(1)->GetSnapshot("m")->revision, 1u);
  EXPECT_EQ(ConnectTo(1)->GetStats("m")->mesh->stats.features, 1u);
  EXPECT_EQ(ConnectTo(1)->GetFeatures("m")->features.size(), 1u);
  EXPECT_TRUE(ConnectTo(1)->Locate("m", 2, std::vector<double>{0.3, 0.4}).ok());
  const auto watch = ConnectTo(1)->Watch("m", {}, nullptr);
  ASSERT_TRUE(other->Apply("m", Point(2)).ok());
  EXPECT_TRUE(watch->WaitFor(
      [](const client::MeshReplica& r) {
        return r.state() == client::MeshReplica::State::kLive && r.revision() == 2;
      },
      absl::Minutes(1)));
  EXPECT_EQ(OwnerOf("m"), AddressOf(0));
  ASSERT_TRUE(ConnectTo(1)->DeleteMesh("m").ok());
  EXPECT_TRUE(absl::IsNotFound(ConnectTo(0)->GetMesh("m").status()));
  EXPECT_TRUE(absl::IsNotFound(ConnectTo(1)->GetMesh("m").status()));
}

// A client that says nothing of redirects, as grpcurl.
TEST_F(OwnershipTest, CallsOfAClientThatDoesNotFollowAreHandedOn) {
  StartNodes(2);
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("m", MeshOptions(), "make").ok());
  ASSERT_TRUE(ConnectTo(0)->Apply("m", Point(1)).ok());
  const auto service = v1::MeshService::NewStub(
      grpc::CreateChannel(AddressOf(1), grpc::InsecureChannelCredentials()));
  const auto call = [&](auto method, const auto& request, auto* response) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kPatience);
    return codec::FromGrpcStatus((service.get()->*method)(&context, request, response));
  };
  using Stub = v1::MeshService::Stub;
  v1::GetMeshRequest get;
  get.set_mesh("meshes/m");
  v1::Mesh mesh;
  EXPECT_EQ(call(&Stub::GetMesh, get, &mesh), absl::OkStatus());
  EXPECT_EQ(mesh.revision(), 1u);
  v1::GetStatsRequest stats;
  stats.set_mesh("meshes/m");
  v1::GetStatsResponse figures;
  EXPECT_EQ(call(&Stub::GetStats, stats, &figures), absl::OkStatus());
  EXPECT_EQ(figures.mesh().features(), 1u);
  v1::LocatePointsRequest locate;
  locate.set_mesh("meshes/m");
  locate.add_coordinates(0.3);
  locate.add_coordinates(0.4);
  v1::LocatePointsResponse located;
  EXPECT_EQ(call(&Stub::LocatePoints, locate, &located), absl::OkStatus());
  EXPECT_EQ(located.simplices().vertex_ids_size(), 3);
  v1::CreateMeshRequest create;
  create.set_mesh_id("m");
  create.set_request_id("make");
  codec::EncodeOptions(MeshOptions(), create.mutable_options());
  create.mutable_options()->clear_max_vertices();
  v1::Mesh made;
  EXPECT_EQ(call(&Stub::CreateMesh, create, &made), absl::OkStatus());
  EXPECT_EQ(made.revision(), 1u);
  v1::DeleteMeshRequest remove;
  remove.set_mesh("meshes/m");
  v1::DeleteMeshResponse removed;
  EXPECT_EQ(call(&Stub::DeleteMesh, remove, &removed), absl::OkStatus());
  EXPECT_TRUE(absl::IsNotFound(call(&Stub::GetMesh, get, &mesh)));
}

// The call ends while the owner is stopped, and the next one is sent to the next owner.
TEST_F(OwnershipTest, ACallThatWasHandedToAStoppedOwnerEnds) {
  StartNodes(2);
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("m", MeshOptions()).ok());
  const auto service = v1::MeshService::NewStub(
      grpc::CreateChannel(AddressOf(1), grpc::InsecureChannelCredentials()));
  const auto get = [&] {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kPatience);
    v1::GetMeshRequest request;
    request.set_mesh("meshes/m");
    v1::Mesh mesh;
    return service->GetMesh(&context, request, &mesh).error_code();
  };
  EXPECT_EQ(get(), grpc::StatusCode::OK);
  nodes_[0]->daemon.Signal(SIGSTOP);
  EXPECT_EQ(get(), grpc::StatusCode::UNAVAILABLE);
  EndLeasesOf(0);
  EXPECT_EQ(get(), grpc::StatusCode::OK);
  EXPECT_EQ(OwnerOf("m"), AddressOf(1));
}

TEST_F(OwnershipTest, AListHasTheMeshesOfAllNodes) {
  StartNodes(2);
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("a", MeshOptions()).ok());
  ASSERT_TRUE(ConnectTo(0)->Apply("a", Point(1)).ok());
  ASSERT_TRUE(ConnectTo(1)->CreateMesh("b", MeshOptions()).ok());
  const auto listed = ConnectTo(1)->ListMeshes();
  ASSERT_TRUE(listed.ok()) << listed.status();
  ASSERT_EQ(listed->size(), 2u);
  EXPECT_EQ((*listed)[0].id, "a");
  EXPECT_EQ((*listed)[0].owner, AddressOf(0));
  EXPECT_EQ((*listed)[0].revision, 1u);
  EXPECT_EQ((*listed)[1].id, "b");
  EXPECT_EQ((*listed)[1].owner, "");
  EXPECT_EQ((*listed)[1].options.quality, MeshOptions().quality);
}

TEST_F(OwnershipTest, AMeshIsMadeOnceWhicheverNodesAreAsked) {
  StartNodes(2);
  for (const std::string id : {"m", ""}) {
    SCOPED_TRACE(id);
    const std::string request = "make-" + id;
    const auto made = ConnectTo(0)->CreateMesh(id, MeshOptions(), request);
    ASSERT_TRUE(made.ok()) << made.status();
    const auto again = ConnectTo(1)->CreateMesh(id, MeshOptions(), request);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ(again->id, made->id);
    EXPECT_EQ(again->create_time, made->create_time);
    const absl::Status other = ConnectTo(1)->CreateMesh(made->id, MeshOptions()).status();
    EXPECT_EQ(ReasonOf(other), codec::reason::kMeshExists) << other;
  }
}

TEST_F(OwnershipTest, AFreeMeshIsOpenedByOneNodeHoweverManyAsk) {
  StartNodes(2, {"--followers", "0"});
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("m", MeshOptions()).ok());
  ASSERT_TRUE(ConnectTo(0)->Apply("m", Point(1)).ok());
  EXPECT_EQ(nodes_[0]->daemon.End(SIGTERM), 0) << nodes_[0]->daemon.Log();
  EXPECT_EQ(Sql("SELECT lease_until FROM dynmesh.meshes"), "-infinity");
  std::vector<std::thread> callers;
  for (int i = 0; i < 8; ++i) {
    callers.emplace_back([this] {
      const auto found = ConnectTo(1)->GetMesh("m");
      EXPECT_TRUE(found.ok()) << found.status();
      EXPECT_EQ(found.ok() ? found->revision : 0, 1u);
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(OwnerOf("m"), AddressOf(1));
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.meshes"), "2");
  // A client of the first node finds the second one.
  const auto client = Connect();
  ASSERT_TRUE(client->Apply("m", Point(2), Request("b")).ok());
}

TEST_F(OwnershipTest, CommandsGoToTheOwnerAndGoOnAtTheNextOne) {
  StartNodes(2);
  const std::string script = nodes_[0]->folder.path() + "/edits.dynmesh";
  std::ofstream out(script);
  out << "mesh dim=2 box=0,0,1,1 rho=1.4142135623730951\n";
  for (int i = 1; i <= 300; ++i) {
    out << "add point " << i << " " << 0.003 * i << " " << 0.1 + 0.003 * (i * 7 % 300)
        << "\ncommit\n";
  }
  out.close();
  const auto run = [](std::vector<std::string> arguments) {
    return cli::RunDynmesh(std::move(arguments));
  };
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("m", MeshOptions()).ok());
  // The mesh moves while the script is applied, or before, or after.
  std::thread mover([this] {
    WaitUntil("some batches", [this] { return ConnectTo(0)->GetMesh("m")->revision > 20; });
    EXPECT_EQ(nodes_[0]->daemon.End(SIGTERM), 0);
  });
  const cli::Ran applied = run({"apply", "m", script, "--server", AddressOf(1) + "," + AddressOf(0),
                                "--request-prefix", "p", "--json"});
  mover.join();
  EXPECT_EQ(applied.code, 0) << applied.err;
  const auto found = ConnectTo(1)->GetMesh("m");
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->revision, 300u);
  EXPECT_EQ(OwnerOf("m"), AddressOf(1));
  const cli::Ran again = run({"apply", "m", script, "--server", AddressOf(1), "--request-prefix",
                              "p", "--quiet", "--json"});
  EXPECT_NE(again.out.find("\"replayed\": 300"), std::string::npos) << again.out;
}

TEST_F(OwnershipTest, FiguresTellEpochsAndTheAgeOfLeases) {
  StartNodes(1, {"--metrics", "127.0.0.1:0"});
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("m", MeshOptions()).ok());
  const std::string log = nodes_[0]->daemon.Log();
  const std::string mark = "event=metrics_listen address=";
  const std::size_t at = log.find(mark);
  ASSERT_NE(at, std::string::npos) << log;
  const std::size_t begin = at + mark.size();
  const std::string address = log.substr(begin, log.find_first_of(" \n", begin) - begin);
  const std::string text =
      server::SendHttp(address, "GET /metrics HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  for (const char* line :
       {"\ndynmesh_mesh_epoch{mesh=\"m\"} 1\n",
        "\ndynmesh_mesh_role{mesh=\"m\",role=\"owner\"} 1\n", "\ndynmesh_lease_seconds 3600\n",
        "\ndynmesh_lease_age_seconds ", "\ndynmesh_journal_fenced_total 0\n",
        "\ndynmesh_journal_unknown_total 0\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
  }
}

TEST_F(OwnershipTest, AFencedOwnersClientsGoToTheNewOwner) {
  StartNodes(2);
  ASSERT_TRUE(ConnectTo(0)->CreateMesh("m", MeshOptions()).ok());
  const auto client = Connect();
  ASSERT_TRUE(client->Apply("m", Point(1), Request("a")).ok());
  const auto watch = Connect()->Watch("m", {}, nullptr);
  // As if the first node had slept: its lease has ended, and the second one claims.
  nodes_[0]->daemon.Signal(SIGSTOP);
  EndLeasesOf(0);
  ASSERT_TRUE(ConnectTo(1)->Apply("m", Point(2), Request("b")).ok());
  nodes_[0]->daemon.Signal(SIGCONT);
  const auto applied = client->Apply("m", Point(3), Request("c"));
  ASSERT_TRUE(applied.ok()) << applied.status();
  EXPECT_EQ(applied->diff.to_revision, 3u);
  EXPECT_EQ(OwnerOf("m"), AddressOf(1));
  EXPECT_TRUE(watch->WaitFor(
      [](const client::MeshReplica& r) {
        return r.state() == client::MeshReplica::State::kLive && r.revision() == 3;
      },
      absl::Minutes(1)));
}

// A short lease. Its end is waited for, and not measured.
class ReadLeaseTest : public ClusterTest {
 protected:
  ReadLeaseTest() : ClusterTest("0.5") {}
};

TEST_F(ReadLeaseTest, AnOwnerThatCannotRenewAnswersNoReadsUntilItCan) {
  StartNodes(1);
  client::ClientOptions options;
  options.timeout = absl::Seconds(2);
  const auto client = MeshClient::Connect(nodes_[0]->address, options);
  ASSERT_TRUE(client->CreateMesh("m", MeshOptions()).ok());
  ASSERT_TRUE(client->GetMesh("m").ok());
  database_.Pause();
  absl::Status refused;
  WaitUntil("the end of reads", [&] {
    refused = client->GetMesh("m").status();
    return !refused.ok();
  });
  database_.Resume();
  EXPECT_EQ(ReasonOf(refused), codec::reason::kNotOwner) << refused;
  WaitUntil("reads", [&] { return client->GetMesh("m").ok(); });
}

}  // namespace
}  // namespace dynmesh::test
