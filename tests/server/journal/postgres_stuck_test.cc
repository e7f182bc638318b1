// A server that stops in the middle of a transaction, or is cut off: the database hears nothing
// more on a connection that stays open. Another server can have the mesh nevertheless.
#include <gtest/gtest.h>

#include <atomic>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/postgres_proxy.h"
#include "tests/server/journal/told.h"

namespace dynmesh::server {
namespace {

class PostgresStuckTest : public PostgresTest {
 protected:
  // The transactions in which the database waits for a statement.
  int Waiting() {
    int count = 0;
    EXPECT_TRUE(absl::SimpleAtoi(
        Sql("SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND state = "
            "'idle in transaction'"),
        &count));
    return count;
  }

  PostgresProxy proxy_{server_.SocketFile()};
};

TEST_F(PostgresStuckTest, ATransactionThatGoesOnNoMoreKeepsNoMesh) {
  PostgresOptions options;
  options.transaction_bytes = 10;
  options.lease = absl::Milliseconds(100);
  const JournalPtr other = Open();
  int stuck = 0, cuts = -1;
  for (int skipped = 0; cuts != proxy_.cuts() && !HasFailure(); ++skipped) {
    SCOPED_TRACE(absl::StrCat("after ", skipped));
    cuts = proxy_.cuts();
    // With connections of its own: nothing is prepared.
    const JournalPtr journal = Open(options, proxy_.folder());
    const Journal::Key key = *other->Create(absl::StrCat("m", skipped), "");
    ASSERT_TRUE(journal->Claim(key).ok());
    ASSERT_TRUE(journal->Append(key, Journal::Entry{1, "x"}, std::nullopt).ok());
    std::atomic<int> waiting{0};  // another thread writes it
    proxy_.CutNext(
        PostgresProxy::Cut::kLate, [&] { waiting = Waiting(); }, skipped);
    (void)journal->Compact(key, 1, {"part-zero", "part-one"});
    proxy_.CutNext(PostgresProxy::Cut::kNone);
    stuck += waiting;
    // What a claim does: it waits for the row.
    EXPECT_EQ(Sql("SET lock_timeout = '30s'; SELECT count(*) FROM (SELECT 1 FROM dynmesh.meshes "
                  "WHERE id = 'm" +
                  std::to_string(skipped) + "' FOR UPDATE) AS locked"),
              "1");
    proxy_.Release();
  }
  EXPECT_GT(stuck, 3);
}

}  // namespace
}  // namespace dynmesh::server
