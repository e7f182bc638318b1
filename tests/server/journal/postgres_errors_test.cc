// Errors of the database and of its address, as an operator sees them.
#include "server/journal/postgres_errors.h"

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/journal/postgres_target.h"
#include "tests/server/journal/postgres_fixture.h"
#include "tests/server/journal/told.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;
using postgres::FailureOf;

TEST(PostgresErrors, WhatComesBeforeACommitIsKnown) {
  for (const char* state :
       {"53100", "53200", "42501", "25006", "40001", "40P01", "57014", "23505"}) {
    EXPECT_FALSE(FailureOf(state, "x").unknown) << state;
    EXPECT_TRUE(absl::IsUnavailable(FailureOf(state, "x").status)) << state;
  }
  for (const char* state : {"08006", "08003", "40003", "57P01", "57P02", "25P03", "XX000", ""}) {
    EXPECT_TRUE(FailureOf(state, "x").unknown) << state;
  }
  for (const char* state : {"XX001", "XX002"}) {
    EXPECT_TRUE(absl::IsDataLoss(FailureOf(state, "x").status));
    EXPECT_FALSE(FailureOf(state, "x").unknown);
  }
}

TEST(PostgresTarget, NamesTheDatabaseWithoutItsPassword) {
  const auto target = postgres::ParseTarget("postgresql://me:se'cret@db1:5433,db2/meshes");
  ASSERT_TRUE(target.ok()) << target.status();
  EXPECT_EQ(target->name, "postgresql://db1,db2/meshes");
  EXPECT_TRUE(absl::StrContains(target->conninfo, "password='se\\'cret'")) << target->conninfo;
  EXPECT_TRUE(absl::StrContains(target->conninfo, "port='5433,'")) << target->conninfo;
  EXPECT_TRUE(absl::StrContains(target->conninfo, "connect_timeout='5'")) << target->conninfo;
  const auto given = postgres::ParseTarget("postgresql:///m?connect_timeout=7");
  EXPECT_TRUE(absl::StrContains(given->conninfo, "connect_timeout='7'")) << given->conninfo;
  const auto leased = postgres::ParseTarget("postgresql:///m", absl::Seconds(3));
  for (const char* part : {"connect_timeout='2'", "keepalives_idle='1'", "keepalives_interval='1'",
                           "tcp_user_timeout='1500'"}) {
    EXPECT_TRUE(absl::StrContains(leased->conninfo, part)) << leased->conninfo;
  }
  EXPECT_EQ(postgres::ParseTarget("postgresql:///m", absl::Minutes(1))->conninfo,
            postgres::ParseTarget("postgresql:///m")->conninfo);
  for (const char* bad : {"", "/folder", "http://db/x", "postgresql://me:secret@db:x:y/z?a=b"}) {
    const absl::Status status = postgres::ParseTarget(bad).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << bad;
    EXPECT_FALSE(absl::StrContains(status.message(), "secret")) << status;
  }
}

class PostgresErrorsTest : public PostgresTest {
 protected:
  // The statement that adds entries fails from now on as the server itself would.
  void FailWith(const std::string& state, const std::string& message) {
    Sql("CREATE OR REPLACE FUNCTION fail() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN RAISE "
        "EXCEPTION '" +
        message + "' USING ERRCODE = '" + state +
        "'; END $$; "
        "CREATE OR REPLACE TRIGGER fail BEFORE INSERT ON dynmesh.entries EXECUTE FUNCTION fail()");
  }
  void Heal() { Sql("DROP TRIGGER fail ON dynmesh.entries"); }
};

TEST_F(PostgresErrorsTest, AFullDiskIsNamedAndCostsNothing) {
  const JournalPtr journal = Open();
  const Journal::Key key = *journal->Create("m", "");
  FailWith("53100", "could not extend file");
  for (int i = 0; i < 2; ++i) {
    const absl::Status status = journal->Append(key, Entry{1, "x"}, Journal::Request{"r", ""});
    EXPECT_EQ(OutcomeOf(status), AppendOutcome::kRefused);
    EXPECT_TRUE(absl::IsUnavailable(status)) << status;
    EXPECT_TRUE(absl::StrContains(status.message(), "disk is full: free space there")) << status;
    EXPECT_TRUE(journal->counts().failing);
  }
  Heal();
  EXPECT_EQ(Told(*journal, key), "");
  EXPECT_TRUE(journal->Append(key, Entry{1, "y"}, std::nullopt).ok());
  EXPECT_FALSE(journal->counts().failing);
  EXPECT_EQ(Told(*journal, key), "1:y ");
}

TEST_F(PostgresErrorsTest, MissingRightsAreNamed) {
  Sql("DO $$ BEGIN CREATE ROLE guest LOGIN; EXCEPTION WHEN duplicate_object THEN END $$");
  const std::string url = absl::StrCat(server_.Url(database_), "?user=guest");
  absl::Status status = OpenPostgresJournal(url, {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_TRUE(absl::StrContains(status.message(), "GRANT CREATE ON DATABASE")) << status;
  ASSERT_NE(Open(), nullptr);
  Sql("GRANT USAGE ON SCHEMA dynmesh TO guest; GRANT SELECT ON ALL TABLES IN SCHEMA dynmesh TO "
      "guest");
  const auto journal = OpenPostgresJournal(url, {});
  ASSERT_TRUE(journal.ok()) << journal.status();
  status = (*journal)->Create("m", "").status();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_TRUE(absl::StrContains(status.message(), "grant it on the schema dynmesh")) << status;
}

TEST_F(PostgresErrorsTest, AnAbsentServerOrDatabaseIsNamed) {
  const absl::Status nowhere = OpenPostgresJournal("postgresql://%2Fnowhere/m", {}).status();
  EXPECT_TRUE(absl::IsUnavailable(nowhere)) << nowhere;
  EXPECT_TRUE(absl::StrContains(nowhere.message(), "postgresql:///nowhere/m: ")) << nowhere;
  const absl::Status none = OpenPostgresJournal(server_.Url("none"), {}).status();
  EXPECT_TRUE(absl::IsUnavailable(none)) << none;
  EXPECT_TRUE(absl::StrContains(none.message(), "\"none\" does not exist")) << none;
}

// A database that was set back has the owner's epoch, and an earlier revision or request.
TEST_F(PostgresErrorsTest, ADatabaseThatLostRevisionsIsNoticedByTheOwner) {
  const JournalPtr journal = Open();
  for (const char* lost : {"head = 1", "answers = 0"}) {
    SCOPED_TRACE(lost);
    const Journal::Key key = *journal->Create(lost[0] == 'h' ? "h" : "a", "");
    ASSERT_TRUE(
        journal->Append(key, {{1, "x"}, {2, "y"}}, std::vector<Journal::Request>{{"r", ""}}).ok());
    Sql(absl::StrCat("UPDATE dynmesh.meshes SET ", lost, " WHERE key = ", key));
    for (int i = 0; i < 2; ++i) {
      const absl::Status status = journal->Append(key, Entry{3, "z"}, std::nullopt);
      EXPECT_TRUE(absl::IsDataLoss(status)) << status;
      EXPECT_TRUE(absl::StrContains(status.message(), "not at the acknowledged 2 and 1")) << status;
    }
    EXPECT_EQ(Sql(absl::StrCat("SELECT count(*) FROM dynmesh.entries WHERE mesh = ", key)), "2");
  }
}

}  // namespace
}  // namespace dynmesh::server
