// A server with real meshes on a free loopback port, in this process, with mesh "m".
#ifndef DYNMESH_TESTS_E2E_E2E_FIXTURE_H_
#define DYNMESH_TESTS_E2E_E2E_FIXTURE_H_

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <random>

#include "absl/time/time.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/base/log.h"
#include "server/server.h"

namespace dynmesh {

inline constexpr absl::Duration kLong = absl::Seconds(60);

class EndToEndTest : public ::testing::Test {
 protected:
  EndToEndTest() {
    EXPECT_TRUE(server::SetLogLevel("error").ok());
    server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    server_ = *server::Server::Start(config, &DynamicMesh::Create);
    client_ = client::MeshClient::Connect(server_->address());
    EXPECT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  }
  server::Head HeadOf() const { return (*server_->registry().Find("meshes/m"))->head(); }

  std::unique_ptr<server::Server> server_;
  std::unique_ptr<client::MeshClient> client_;
};

// Random points in the middle of the unit box, as edits.
inline EditBatch RandomPoints(std::mt19937_64& random, FeatureId first, std::size_t count) {
  std::uniform_real_distribution<double> unit(0.1, 0.9);
  EditBatch batch;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = unit(random), y = unit(random);
    batch.push_back(Edit::Add(Feature::Point(first + i, x, y)));
  }
  return batch;
}

}  // namespace dynmesh

#endif  // DYNMESH_TESTS_E2E_E2E_FIXTURE_H_
