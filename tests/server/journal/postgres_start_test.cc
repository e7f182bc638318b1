// Servers that start at once on one database: each table is made once, and all of them serve.
#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/journal/postgres_schema.h"
#include "server/journal/postgres_target.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/postgres_proxy.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

constexpr int kServers = 5;

class PostgresStartTest : public PostgresTest {
 protected:
  // Holds the lock that makes servers take turns, until all of them wait for it.
  void OpenAllBehind(std::int64_t lock, const PostgresOptions& options) {
    const auto target = postgres::ParseTarget(server_.Url(database_));
    auto holder = postgres::Session::Connect(target->conninfo);
    ASSERT_TRUE(holder.ok()) << holder.status();
    ASSERT_TRUE(
        (*holder)->Execute(absl::StrCat("SELECT pg_advisory_lock(", lock, ")")).status.ok());
    std::vector<absl::Status> opened(kServers);
    std::vector<std::thread> threads;
    for (absl::Status& status : opened) {
      threads.emplace_back(
          [&] { status = PostgresJournal::Open(server_.Url(database_), options).status(); });
    }
    test::WaitUntil("servers that wait", [this] {
      return Sql("SELECT count(*) FROM pg_locks WHERE locktype = 'advisory' AND NOT granted AND "
                 "database = (SELECT oid FROM pg_database WHERE datname = current_database())") ==
             std::to_string(kServers);
    });
    holder->reset();  // which gives the lock up
    for (std::thread& thread : threads) thread.join();
    for (const absl::Status& status : opened) EXPECT_TRUE(status.ok()) << status;
  }
};

TEST_F(PostgresStartTest, TheFirstServersMakeTheTablesInTurn) {
  OpenAllBehind(28'281'012'859'794'280, {});
  EXPECT_EQ(Sql("SELECT version FROM dynmesh.journal"), absl::StrCat(postgres::kPostgresSchema));
}

TEST_F(PostgresStartTest, TheFirstServersWithLeasesMakeTheirTablesInTurn) {
  Open().reset();
  PostgresOptions options;
  options.lease = absl::Hours(1);
  OpenAllBehind(28'273'260'616'281'960, options);
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.nodes"), "0");
}

// A database that is busy or restarts may end a connection that it has made.
TEST_F(PostgresStartTest, ALostConnectionIsTriedAgain) {
  PostgresOptions options;
  options.lease = absl::Hours(1);
  Open(options).reset();
  PostgresProxy proxy(server_.SocketFile());
  const std::string url = server_.Url(database_, proxy.folder());
  int lost = 0;
  for (int answers = 0; answers < 12; ++answers) {
    SCOPED_TRACE(answers);
    const int before = proxy.cuts();
    proxy.CutNext(PostgresProxy::Cut::kAnswer, nullptr, answers);
    const auto opened = PostgresJournal::Open(url, options);
    EXPECT_TRUE(opened.ok()) << opened.status();
    lost += proxy.cuts() - before;
    proxy.CutNext(PostgresProxy::Cut::kNone);
  }
  EXPECT_GT(lost, 6);
}

// As a version before the index has left it.
TEST_F(PostgresStartTest, TheIndexOfRenewalsIsMadeForOlderTablesToo) {
  PostgresOptions options;
  options.lease = absl::Hours(1);
  const char* const kIndexes =
      "SELECT count(*) FROM pg_indexes WHERE indexname = 'meshes_by_owner' AND "
      "schemaname = 'dynmesh'";
  Open(options).reset();
  EXPECT_EQ(Sql(kIndexes), "1");
  Sql("DROP INDEX dynmesh.meshes_by_owner");
  OpenAllBehind(28'273'260'616'281'960, options);
  EXPECT_EQ(Sql(kIndexes), "1");
}

// Of a table with meshes of many servers.
TEST_F(PostgresStartTest, ARenewalReadsTheMeshesOfItsServerOnly) {
  PostgresOptions options;
  options.lease = absl::Hours(1);
  Open(options).reset();
  Sql("INSERT INTO dynmesh.meshes(id, description, checksum, owner) SELECT 'm' || n, '', 0, "
      "'node-' || n % 200 FROM generate_series(1, 20000) AS n; ANALYZE dynmesh.meshes");
  const std::string plan = Sql(
      "EXPLAIN UPDATE dynmesh.meshes SET lease_until = clock_timestamp() WHERE owner = 'node-7' "
      "AND lease_until > '-infinity'");
  EXPECT_NE(plan.find("meshes_by_owner"), std::string::npos) << plan;
}

}  // namespace
}  // namespace dynmesh::server
