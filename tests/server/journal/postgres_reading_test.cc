// Reading a mesh from PostgreSQL while what is read is worked on: that may take longer than a
// lease, and a reader that stops keeps nothing for ever.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/base/mesh_name.h"
#include "server/journal/postgres_errors.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/postgres_proxy.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;

class PostgresReadingTest : public PostgresTest {
 protected:
  // The entries are written without leases, which may be short.
  void Make(const PostgresOptions& options, const std::string& socket = "") {
    const JournalPtr writer = Open();
    key_ = *writer->Create("m", "");
    for (std::uint64_t r = 1; r <= 3; ++r) {
      ASSERT_TRUE(writer->Append(key_, Entry{r, absl::StrCat("e", r)}, std::nullopt).ok());
    }
    journal_ = Open(options, socket);
  }
  // Reads all entries, with `work` after each.
  template <class Work>
  std::string Read(bool past, Work work) {
    return ToldBy([&](const Journal::Visitor& telling) {
      Journal::Visitor visitor = telling;
      visitor.entry = [&](const Entry& entry) {
        work(entry);
        return telling.entry(entry);
      };
      return past ? journal_->ReadPast(key_, 0, 3, visitor) : journal_->Read(key_, visitor);
    });
  }
  std::string OpenTransactions() {
    return Sql(
        "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND "
        "application_name = 'dynmeshd' AND state LIKE 'idle in transaction%'");
  }

  JournalPtr journal_;
  Journal::Key key_ = 0;
};

// Of a transaction that writes, the database takes half a second for the end of such a lease.
TEST_F(PostgresReadingTest, AMeshIsReadThoughItsEntriesTakeLongerThanALease) {
  PostgresOptions options;
  options.lease = absl::Milliseconds(100);
  Make(options);
  const auto work = [](const Entry&) { absl::SleepFor(absl::Milliseconds(700)); };
  EXPECT_EQ(Read(/*past=*/false, work), "1:e1 2:e2 3:e3 ");
  EXPECT_EQ(Read(/*past=*/true, work), "1:e1 2:e2 3:e3 ");
}

// The database itself says that the reader has worked for long enough.
TEST_F(PostgresReadingTest, AReaderThatWorksKeepsItsTransactionBeyondTheReadersLimit) {
  PostgresOptions options;
  options.reading_idle = absl::Seconds(3);
  Make(options);
  const auto work = [this](const Entry& entry) {
    if (entry.revision != 2) return;
    test::WaitUntil("twice the limit", [this] {
      absl::SleepFor(absl::Milliseconds(100));
      return Sql("SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND "
                 "clock_timestamp() - xact_start > interval '6 s'") != "0";
    });
  };
  EXPECT_EQ(Read(/*past=*/false, work), "1:e1 2:e2 3:e3 ");
}

TEST_F(PostgresReadingTest, AReaderThatStopsLosesItsTransactionAndKeepsNoRow) {
  PostgresProxy proxy(server_.SocketFile());
  PostgresOptions options;
  options.reading_idle = absl::Seconds(1);
  Make(options, proxy.folder());
  // From its first entry on the database hears nothing more on a connection that stays open. On a
  // machine that stands still for a second the transaction has ended before that: once more.
  std::string open;
  test::WaitUntil("a reader that is cut off in its transaction", [&] {
    const int before = proxy.cuts();
    const std::string read = Read(/*past=*/false, [&](const Entry& entry) {
      if (entry.revision != 1) return;
      proxy.CutNext(PostgresProxy::Cut::kLate, [&] { open = OpenTransactions(); });
      test::WaitUntil("the reader's next statement",
                      [&] { return proxy.cuts() > before || OpenTransactions() == "0"; });
    });
    EXPECT_TRUE(absl::StartsWith(read, "UNAVAILABLE")) << read;
    proxy.CutNext(PostgresProxy::Cut::kNone);
    if (open != "1") proxy.Release();
    return open == "1";
  });
  // What a writer does meanwhile: it waits for the row.
  EXPECT_EQ(Sql("SET lock_timeout = '1s'; SELECT count(*) FROM (SELECT 1 FROM dynmesh.meshes FOR "
                "UPDATE) AS locked"),
            "1");
  test::WaitUntil("the end of the transaction", [&] { return OpenTransactions() == "0"; });
  proxy.Release();
  EXPECT_EQ(Read(/*past=*/false, [](const Entry&) {}), "1:e1 2:e2 3:e3 ");
}

// It says why when it ends a connection on which nothing is under way.
TEST_F(PostgresReadingTest, TheLastWordsOfTheDatabaseAreHandedOn) {
  Make({});
  const std::string read = Read(/*past=*/false, [this](const Entry& entry) {
    if (entry.revision != 1) return;
    Sql("SELECT pg_terminate_backend(pid, 10000) FROM pg_stat_activity WHERE datname = "
        "current_database() AND state LIKE 'idle in transaction%'");
  });
  EXPECT_TRUE(absl::StrContains(read, "administrator command")) << read;
}

TEST_F(PostgresReadingTest, WhatEndedAReadingIsSaidAndNoDiskIsBlamed) {
  const absl::Status idle =
      postgres::ConnectionLost("FATAL:  terminating connection due to idle-in-transaction timeout")
          .status;
  EXPECT_TRUE(absl::StrContains(idle.message(), "did not go on with it in time")) << idle;
  const absl::Status told = JournalReadError(idle, "m");
  EXPECT_EQ(told.code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(absl::StrContains(told.message(), "could not be read from the journal")) << told;
  for (const char* wrong : {"disk", "written", "restore"}) {
    EXPECT_FALSE(absl::StrContains(told.message(), wrong)) << told;
  }
  EXPECT_TRUE(absl::IsNotFound(JournalReadError(absl::NotFoundError("no"), "m")));
}

}  // namespace
}  // namespace dynmesh::server
