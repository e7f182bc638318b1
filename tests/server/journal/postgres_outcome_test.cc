// Appends whose answer is lost: what becomes of them is found out, and nothing is written twice.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <string>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/postgres_proxy.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"
#include "tests/support/seed.h"

namespace dynmesh::server {
namespace {

using Cut = PostgresProxy::Cut;
using Entry = Journal::Entry;
using Request = Journal::Request;

class PostgresOutcomeTest : public PostgresTest {
 protected:
  PostgresOutcomeTest() {
    // The statement is prepared: the next answer is that of an append.
    EXPECT_TRUE(Append(1).ok());
  }
  ~PostgresOutcomeTest() override {
    proxy_.Refuse(false);
    if (synchronous_) SetStandbys("");
  }

  absl::Status Append(std::uint64_t revision) {
    return journal_->Append(key_, Entry{revision, absl::StrCat("e", revision)},
                            Request{absl::StrCat("r", revision), "A"});
  }
  // The journal has all revisions up to `last`, each once.
  void ExpectAll(std::uint64_t last) {
    std::string requests, entries;
    for (std::uint64_t r = 1; r <= last; ++r) {
      absl::StrAppend(&requests, "?r", r, "=A ");
      absl::StrAppend(&entries, r, ":e", r, " ");
    }
    EXPECT_EQ(Told(*journal_, key_), requests + entries);
  }
  void SetStandbys(const std::string& names) {
    synchronous_ = !names.empty();
    server_.Sql("postgres", "ALTER SYSTEM SET synchronous_standby_names = '" + names + "'");
    server_.Sql("postgres", "SELECT pg_reload_conf()");
    test::WaitUntil("the setting", [&] {
      return server_.Sql("postgres", "SHOW synchronous_standby_names") == names;
    });
  }
  // Until a commit waits for a standby; calls `function` with its process.
  void WithWaitingCommit(const std::string& function) {
    std::string process;
    test::WaitUntil("a commit that waits for a standby", [&] {
      process = Sql("SELECT pid FROM pg_stat_activity WHERE wait_event = 'SyncRep' LIMIT 1");
      return !process.empty();
    });
    Sql("SELECT " + function + "(" + process + ")");
  }

  PostgresProxy proxy_{server_.SocketFile()};
  PostgresOptions options_ = {.resolve_for = absl::Milliseconds(500)};
  JournalPtr journal_ = Open(options_, proxy_.folder());
  const Journal::Key key_ = *journal_->Create("m", "");
  bool synchronous_ = false;
};

TEST_F(PostgresOutcomeTest, AnAppendWithoutItsAnswerIsFound) {
  proxy_.CutNext(Cut::kAnswer);
  EXPECT_TRUE(Append(2).ok());
  EXPECT_EQ(proxy_.cuts(), 1);
  ExpectAll(2);
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.meshes"), "2");
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.entries ORDER BY revision"), "1 1");
  EXPECT_TRUE(Append(3).ok());
  ExpectAll(3);
}

TEST_F(PostgresOutcomeTest, AnAppendThatNeverArrivedIsSentAgain) {
  proxy_.CutNext(Cut::kQuestion);
  EXPECT_TRUE(Append(2).ok());
  EXPECT_EQ(proxy_.cuts(), 1);
  ExpectAll(2);
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.entries ORDER BY revision"), "1 2");
}

TEST_F(PostgresOutcomeTest, AnAppendThatArrivesLateIsRefused) {
  proxy_.CutNext(Cut::kLate);
  EXPECT_TRUE(Append(2).ok());
  proxy_.Release();
  ExpectAll(2);
  EXPECT_EQ(Sql("SELECT epoch FROM dynmesh.entries ORDER BY revision"), "1 2");
}

TEST_F(PostgresOutcomeTest, AnswersWithoutARevisionAreFoundToo) {
  proxy_.CutNext(Cut::kAnswer);
  EXPECT_TRUE(journal_->Append(key_, {}, std::vector<Request>{{"r2", "A"}}).ok());
  proxy_.CutNext(Cut::kQuestion);
  EXPECT_TRUE(journal_->Append(key_, {}, std::vector<Request>{{"r3", "A"}}).ok());
  EXPECT_EQ(proxy_.cuts(), 2);
  EXPECT_EQ(Told(*journal_, key_), "?r1=A ?r2=A ?r3=A 1:e1 ");
}

TEST_F(PostgresOutcomeTest, WhatCannotBeFoundOutStaysUnknownUntilTheNextClaim) {
  proxy_.CutNext(Cut::kAnswer, [this] { proxy_.Refuse(true); });
  for (int i = 0; i < 2; ++i) EXPECT_EQ(OutcomeOf(Append(2)), AppendOutcome::kUnknown);
  EXPECT_TRUE(journal_->counts().failing);
  proxy_.Refuse(false);
  EXPECT_EQ(OutcomeOf(Append(2)), AppendOutcome::kUnknown);
  EXPECT_TRUE(absl::IsUnknown(journal_->Compact(key_, 1, {"p"})));
  ASSERT_TRUE(journal_->Claim(key_).ok());
  ExpectAll(2);
  EXPECT_TRUE(Append(3).ok());
  EXPECT_FALSE(journal_->counts().failing);
  ExpectAll(3);
}

TEST_F(PostgresOutcomeTest, WhatAnotherOwnerMayHaveChangedIsUnknown) {
  const JournalPtr other = Open();
  proxy_.CutNext(Cut::kAnswer, [&] { EXPECT_TRUE(other->Claim(key_).ok()); });
  EXPECT_EQ(OutcomeOf(Append(2)), AppendOutcome::kUnknown);
  EXPECT_EQ(proxy_.cuts(), 1);
  ExpectAll(2);
  EXPECT_TRUE(other->Append(key_, Entry{3, "e3"}, Request{"r3", "A"}).ok());
  ExpectAll(3);
}

// Without a connection to the database, and with leases.
class PostgresCutOffTest : public PostgresOutcomeTest {
 protected:
  PostgresCutOffTest() { OpenWith(absl::Milliseconds(300)); }

  void OpenWith(absl::Duration lease) {
    journal_.reset();
    // Longer than a test may take: what waits for these fails.
    options_.resolve_for = absl::Hours(1);
    options_.lease = lease;
    const std::string url = server_.Url(database_, proxy_.folder()) + "?connect_timeout=3600";
    auto opened = PostgresJournal::Open(url, options_);
    ASSERT_TRUE(opened.ok()) << opened.status();
    journal_ = *std::move(opened);
    test::WaitUntil("the end of the lease", [this] { return journal_->Claim(key_).ok(); });
    EXPECT_TRUE(journal_->Renew("here:1").ok());
    EXPECT_TRUE(Append(++last_).ok());  // prepared, as above
  }
  // It is claimed by this journal, by another one, and written to by both in turn.
  void ExpectThatAllGoesOn() {
    ASSERT_TRUE(journal_->Claim(key_).ok());
    ExpectAll(++last_);
    EXPECT_TRUE(Append(++last_).ok());
    const JournalPtr other = Open(options_);
    test::WaitUntil("the end of the lease", [&] { return other->Claim(key_).ok(); });
    EXPECT_EQ(OutcomeOf(Append(++last_)), AppendOutcome::kFenced);
    const std::string number = absl::StrCat(last_);
    EXPECT_TRUE(other->Append(key_, Entry{last_, "e" + number}, Request{"r" + number, "A"}).ok());
    ExpectAll(last_);
  }

  std::uint64_t last_ = 1;  // revision
};

TEST_F(PostgresCutOffTest, AnOutcomeIsLookedForUntilTheLeaseEnds) {
  proxy_.CutNext(Cut::kAnswer, [this] { proxy_.Refuse(true); });
  EXPECT_EQ(OutcomeOf(Append(last_ + 1)), AppendOutcome::kUnknown);
  proxy_.Refuse(false);
  ExpectThatAllGoesOn();
}

TEST_F(PostgresCutOffTest, AConnectionThatIsNotMadeIsNotWaitedForLonger) {
  proxy_.CutNext(Cut::kAnswer, [this] { proxy_.Ignore(true); });
  EXPECT_EQ(OutcomeOf(Append(last_ + 1)), AppendOutcome::kUnknown);
  proxy_.Ignore(false);
  ExpectThatAllGoesOn();
}

TEST_F(PostgresCutOffTest, WhetherAMeshWasMadeOrDeletedMayStayUnknown) {
  // Prepared, as above.
  ASSERT_TRUE(journal_->Delete(*journal_->Create("prepared", "")).ok());
  proxy_.CutNext(
      Cut::kAnswer, [this] { proxy_.Ignore(true); }, /*skipped=*/1);  // that of the key
  const absl::Status made = journal_->Create("other", "").status();
  EXPECT_TRUE(absl::IsUnknown(made)) << made;
  proxy_.Ignore(false);
  EXPECT_TRUE(absl::IsAlreadyExists(journal_->Create("other", "").status()));

  ASSERT_TRUE(journal_->Delete(*journal_->Create("third", "")).ok());
  proxy_.CutNext(Cut::kAnswer, [this] { proxy_.Ignore(true); });
  const absl::Status deleted = journal_->Delete(key_);
  EXPECT_TRUE(absl::IsUnknown(deleted)) << deleted;
  proxy_.Ignore(false);
  EXPECT_TRUE(absl::IsNotFound(journal_->Delete(key_)));
}

TEST_F(PostgresCutOffTest, WhileTheLeaseIsRenewedTheOutcomeIsLookedFor) {
  OpenWith(absl::Seconds(2));
  proxy_.CutNext(Cut::kAnswer, [this] { proxy_.Refuse(true); });
  absl::Status appended = absl::InternalError("none");
  std::atomic<bool> over{false};
  std::thread writer([&] {
    appended = Append(last_ + 1);
    over = true;
  });
  test::WaitUntil("the end of the connection", [this] { return proxy_.cuts() == 1; });
  const absl::Time end = absl::Now() + 1.5 * options_.lease;
  while (absl::Now() < end) {
    EXPECT_TRUE(journal_->Renew("here:1").ok());
    absl::SleepFor(absl::Milliseconds(10));
  }
  EXPECT_FALSE(over);
  proxy_.Refuse(false);
  writer.join();
  EXPECT_TRUE(appended.ok()) << appended;
  ExpectAll(last_ + 1);
}

TEST_F(PostgresOutcomeTest, AMeshThatWasSetBackMeanwhileIsNotGoneOnWith) {
  proxy_.CutNext(Cut::kQuestion, [&] { Sql("UPDATE dynmesh.meshes SET head = 0"); });
  const absl::Status status = Append(2);
  EXPECT_TRUE(absl::IsDataLoss(status)) << status;
  EXPECT_TRUE(absl::StrContains(status.message(), "not at the acknowledged 1 and 1")) << status;
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.entries"), "1");
}

TEST_F(PostgresOutcomeTest, WithoutAConnectionAnAppendIsRefusedAtOnce) {
  journal_.reset();
  options_.resolve_for = absl::Minutes(1);
  journal_ = Open(options_, proxy_.folder());
  ASSERT_TRUE(journal_->Claim(key_).ok());
  proxy_.Refuse(true);
  Sql("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'dynmeshd'");
  test::WaitUntil("the end of the connections", [this] {
    return Sql("SELECT count(*) FROM pg_stat_activity WHERE application_name = 'dynmeshd'") == "0";
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // through the proxy
  for (int i = 0; i < 2; ++i) {
    const absl::Status status = Append(2);
    EXPECT_EQ(OutcomeOf(status), AppendOutcome::kRefused);
    EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  }
  proxy_.Refuse(false);
  EXPECT_TRUE(Append(2).ok());
  ExpectAll(2);
}

TEST_F(PostgresOutcomeTest, ACommitThatIsEndedWhileItWaitsForAStandbyIsFound) {
  journal_.reset();
  options_.resolve_for = absl::Minutes(1);
  journal_ = Open(options_);
  ASSERT_TRUE(journal_->Claim(key_).ok());
  std::uint64_t revision = 1;
  for (const char* function : {"pg_terminate_backend", "pg_cancel_backend"}) {
    SCOPED_TRACE(function);
    SetStandbys("ANY 1 (absent)");
    absl::Status appended = absl::InternalError("none");
    std::thread writer([&] { appended = Append(++revision); });
    WithWaitingCommit(function);
    // The search waits for a standby as well: an answer before would promise too much.
    test::WaitUntil("the search for the outcome", [&] {
      return Sql("SELECT count(*) FROM pg_stat_activity WHERE wait_event = 'SyncRep' AND query "
                 "LIKE 'UPDATE%'") == "1";
    });
    SetStandbys("");
    writer.join();
    EXPECT_TRUE(appended.ok()) << appended;
    ExpectAll(revision);
  }
}

TEST_F(PostgresOutcomeTest, ConnectionsThatAreCutAtRandomLoseAndDoubleNothing) {
  journal_.reset();
  options_.resolve_for = absl::Minutes(1);
  journal_ = Open(options_, proxy_.folder());
  ASSERT_TRUE(journal_->Claim(key_).ok());
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  std::uint64_t last = 1;
  for (int i = 0; i < 150; ++i) {
    if (random() % 2 == 0) {
      constexpr Cut kCuts[] = {Cut::kAnswer, Cut::kQuestion, Cut::kLate};
      proxy_.CutNext(kCuts[random() % 3]);
    }
    const absl::Status status = Append(last + 1);
    ASSERT_TRUE(status.ok()) << status;
    ++last;
    if (random() % 4 == 0) proxy_.Release();
  }
  EXPECT_GT(proxy_.cuts(), 30);
  proxy_.Release();
  ExpectAll(last);
}

}  // namespace
}  // namespace dynmesh::server
