// A database server that ends and comes back, and one with a synchronous standby.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;

// Appends until it is ended; counts what was acknowledged.
class Writer {
 public:
  Writer(Journal& journal, Journal::Key key)
      : thread_([this, &journal, key] {
          while (!ends_) {
            const std::uint64_t next = acknowledged_ + 1;
            const absl::Status status =
                journal.Append(key, Entry{next, absl::StrCat("e", next)}, std::nullopt);
            if (status.ok()) {
              acknowledged_ = next;
            } else if (OutcomeOf(status) != AppendOutcome::kRefused) {
              ADD_FAILURE() << status;
              return;
            }
          }
        }) {}
  ~Writer() { End(); }
  void End() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::uint64_t acknowledged() const { return acknowledged_; }
  void WaitForMore(std::uint64_t count) {
    const std::uint64_t before = acknowledged_;
    test::WaitUntil("appends", [&] { return acknowledged_ >= before + count; });
  }

 private:
  std::atomic<bool> ends_{false};
  std::atomic<std::uint64_t> acknowledged_{0};
  std::thread thread_;
};

std::string AllUpTo(std::uint64_t last) {
  std::string told;
  for (std::uint64_t r = 1; r <= last; ++r) absl::StrAppend(&told, r, ":e", r, " ");
  return told;
}

TEST(PostgresRestart, AppendsGoOnAfterTheServerWasKilled) {
  ASSERT_TRUE(SetLogLevel("off").ok());
  PostgresServer server;
  const std::string database = server.MakeDatabase();
  const auto journal = *PostgresJournal::Open(server.Url(database), {});
  const Journal::Key key = *journal->Create("m", "");
  Writer writer(*journal, key);
  for (int i = 0; i < 3; ++i) {
    writer.WaitForMore(20);
    server.Kill();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    server.Start();
    writer.WaitForMore(20);
  }
  writer.End();
  EXPECT_EQ(Told(*journal, key), AllUpTo(writer.acknowledged()));
}

TEST(PostgresStandby, HasWhatWasAcknowledgedAndGoesOnWithIt) {
  ASSERT_TRUE(SetLogLevel("off").ok());
  PostgresServer primary({"synchronous_standby_names=ANY 1 (one)"});
  // Before there is a standby, nothing is waited for.
  primary.Sql("postgres", "SET synchronous_commit = local; CREATE TABLE made()");
  PostgresServer standby(primary, "one");
  const std::string database = primary.MakeDatabase();
  test::WaitUntil("the database on the standby", [&] {
    return standby.Sql("postgres", "SELECT count(*) FROM pg_database WHERE datname = '" + database +
                                       "'") == "1";
  });
  std::string url = primary.Url(database);
  const std::string other = standby.Url(database);
  const std::size_t host = url.find('@') + 1, end = url.find("/" + database);
  url.insert(end, "," + other.substr(host, end - host));

  const auto journal = *PostgresJournal::Open(url, {});
  const Journal::Key key = *journal->Create("m", "");
  Writer writer(*journal, key);
  writer.WaitForMore(50);
  standby.Pause();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const std::uint64_t before = writer.acknowledged();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(writer.acknowledged(), before) << "acknowledged without a standby";
  standby.Resume();
  writer.WaitForMore(50);

  primary.Kill();
  EXPECT_EQ(standby.Sql("postgres", "SELECT pg_promote()"), "t");
  writer.WaitForMore(50);
  writer.End();
  EXPECT_EQ(Told(*journal, key), AllUpTo(writer.acknowledged()));
}

}  // namespace
}  // namespace dynmesh::server
