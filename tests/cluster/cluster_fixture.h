// Several dynmeshd that share the meshes of one PostgreSQL database.
#ifndef DYNMESH_TESTS_CLUSTER_CLUSTER_FIXTURE_H_
#define DYNMESH_TESTS_CLUSTER_CLUSTER_FIXTURE_H_

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/e2e/daemon.h"
#include "tests/server/journal/postgres_server.h"
#include "tests/support/deadline.h"
#include "tests/support/held_port.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::test {

class ClusterTest : public ::testing::Test {
 protected:
  using MeshClient = client::MeshClient;

  // A server whose address outlives its process.
  struct Node {
    HeldPort port;
    TempFolder folder;
    Daemon daemon{folder.path()};
    const std::string address = port.address();
  };

  explicit ClusterTest(const std::string& lease = "3") : lease_(lease) {}

  std::vector<std::string> Flags() const {
    std::vector<std::string> flags = {"--journal",       database_.Url("postgres"),
                                      "--node-address",  "127.0.0.1",
                                      "--lease",         lease_,
                                      "--compact-bytes", "4000"};
    flags.insert(flags.end(), more_.begin(), more_.end());
    return flags;
  }
  void StartNodes(int count, const std::vector<std::string>& more = {}) {
    more_ = more;
    const std::vector<std::string> flags = Flags();
    for (int i = 0; i < count; ++i) {
      nodes_.push_back(std::make_unique<Node>());
      Node& node = *nodes_.back();
      ASSERT_TRUE(node.daemon.Start(flags, node.address.c_str())) << node.daemon.Log();
    }
  }
  // At the same address, with the same flags.
  void Restart(Node& node) {
    ASSERT_TRUE(node.daemon.Start(Flags(), node.address.c_str())) << node.daemon.Log();
  }
  Node& At(const std::string& address) {
    for (const auto& node : nodes_) {
      if (node->address == address) return *node;
    }
    throw std::runtime_error("no node is at '" + address + "'");
  }

  // Knows all nodes, unless addresses are given.
  std::unique_ptr<MeshClient> Connect(const std::string& addresses = "") const {
    std::vector<std::string> all;
    for (const auto& node : nodes_) all.push_back(node->address);
    client::ClientOptions options;
    options.own_connection = true;
    return MeshClient::Connect(addresses.empty() ? absl::StrJoin(all, ",") : addresses, options);
  }

  std::string Sql(const std::string& sql) const { return database_.Sql("postgres", sql); }
  // The address of the node that has the mesh, by the database.
  std::string OwnerOf(const std::string& mesh) const {
    return Sql(
        "SELECT n.address FROM dynmesh.meshes AS m JOIN dynmesh.nodes AS n ON n.id = "
        "m.owner WHERE m.id = '" +
        mesh + "'");
  }

  const std::string lease_;
  std::vector<std::string> more_;  // flags
  server::PostgresServer database_;
  std::vector<std::unique_ptr<Node>> nodes_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_CLUSTER_CLUSTER_FIXTURE_H_
