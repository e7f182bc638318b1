// The tests that need a PostgreSQL server. Ends with 77 where none is installed.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

#include "tests/server/journal/postgres_server.h"

namespace dynmesh::server {
namespace {

std::unique_ptr<PostgresServer> shared;

// Stops it before the program's objects go.
class StopShared final : public ::testing::Environment {
 public:
  void TearDown() override { shared.reset(); }
};

}  // namespace

PostgresServer& SharedPostgres() {
  if (shared == nullptr) shared = std::make_unique<PostgresServer>();
  return *shared;
}

}  // namespace dynmesh::server

// Read by LeakSanitizer. libpqxx 6.4 loses the result of a statement if the connection broke: it
// asks the connection for its encoding before it takes the result.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libpqxx\n";
}

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (dynmesh::server::PostgresServer::Programs().empty()) {
    std::printf("skipped: there is no PostgreSQL server (Debian: postgresql)\n");
    return 77;
  }
  ::testing::AddGlobalTestEnvironment(new dynmesh::server::StopShared);
  return RUN_ALL_TESTS();
}
