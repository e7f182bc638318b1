// A server that stops in the middle of a transaction, or is cut off: the database hears nothing
// more on a connection that stays open. Another server can have the mesh nevertheless. And the
// reverse: a database that does not answer.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/postgres_proxy.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"

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
    ASSERT_TRUE(other->Append(key, Journal::Entry{1, "x"}, std::nullopt).ok());
    test::WaitUntil("the mesh", [&] { return journal->Claim(key).ok(); });
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

// Of two appends to a mesh, one is the database's and the other waits for its turn.
TEST_F(PostgresStuckTest, AtTheEndWhatTheDatabaseHasIsWaitedForAndTheRestIsRefused) {
  const JournalPtr journal = Open();
  const Journal::Key key = *journal->Create("m", "");
  ASSERT_TRUE(journal->Append(key, Journal::Entry{1, "x"}, std::nullopt).ok());
  EXPECT_EQ(journal->counts().oldest_write, absl::ZeroDuration());
  server_.Pause();
  absl::Status first, second;
  std::thread writer([&] { first = journal->Append(key, Journal::Entry{2, "y"}, std::nullopt); });
  test::WaitUntil("the first append",
                  [&] { return journal->counts().oldest_write > absl::Seconds(1); });
  std::thread other([&] { second = journal->Append(key, Journal::Entry{3, "z"}, std::nullopt); });
  journal->EndWrites(absl::UnavailableError("it ends"));
  EXPECT_EQ(journal->Create("n", "").status().message(), "it ends");
  server_.Resume();
  writer.join();
  other.join();
  EXPECT_TRUE(first.ok()) << first;
  EXPECT_EQ(second.message(), "it ends");
  EXPECT_EQ(Told(*journal, key), "1:x 2:y ");
}

}  // namespace
}  // namespace dynmesh::server
