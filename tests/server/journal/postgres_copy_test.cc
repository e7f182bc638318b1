// Copies between a folder and PostgreSQL, and databases that are in use.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "server/journal/journal_copy.h"
#include "tests/server/journal/copy_fixture.h"
#include "tests/server/journal/postgres_fixture.h"

namespace dynmesh::server {
namespace {

class PostgresCopyTest : public PostgresTest {
 protected:
  static PostgresOptions Exclusive() {
    PostgresOptions options;
    options.exclusive = true;
    return options;
  }
  absl::Status StatusOfOpen(const PostgresOptions& options) const {
    return PostgresJournal::Open(server_.Url(database_), options).status();
  }

  test::TempFolder folder_;
};

TEST_F(PostgresCopyTest, ThereAndBackEachReaderSeesTheSame) {
  SqliteJournal::Options small;
  small.history_bytes = 12'000;
  const auto from = OpenSqlite(folder_.path(), small);
  JournalFiller(*from, 8).FillAll();
  const std::vector<std::string> before = ToldAll(*from);
  CopyOptions options;
  options.transaction_bytes = 700;
  {
    const JournalPtr database = Open(Exclusive());
    const auto there = CopyMeshes(*from, *database, options);
    ASSERT_TRUE(there.ok()) << there.status();
    EXPECT_EQ(there->copied, 6u);
    EXPECT_EQ(ToldAll(*database), before);
  }
  const JournalPtr database = Open(Exclusive());
  test::TempFolder back_folder;
  const auto back = OpenSqlite(back_folder.path());
  const auto counts = CopyMeshes(*database, *back, options);
  ASSERT_TRUE(counts.ok()) << counts.status();
  EXPECT_EQ(ToldAll(*back), before);
  EXPECT_EQ(CopyMeshes(*from, *database, options)->there, 6u);
  // What the database has is a journal: it can be claimed and written to.
  const Journal::Mesh mesh = database->List()->front();
  ASSERT_TRUE(database->Claim(mesh.key).ok());
  ASSERT_TRUE(database->Append(mesh.key, std::nullopt, Journal::Request{"r", "a"}).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(CopyMeshes(*from, *database, options).status()));
}

TEST_F(PostgresCopyTest, ACopiedMeshCanBeLeasedAtOnce) {
  const auto from = OpenSqlite(folder_.path());
  JournalFiller(*from, 9).Fill("m", 2, 12, 5);
  PostgresOptions leased;
  leased.lease = absl::Seconds(30);
  Open(leased).reset();  // its tables have leases
  {
    const JournalPtr database = Open(Exclusive());
    ASSERT_TRUE(CopyMeshes(*from, *database, {}).ok());
  }
  const JournalPtr node = Open(leased);
  const auto place = node->Locate("m");
  ASSERT_TRUE(place.ok()) << place.status();
  EXPECT_LE(place->left, absl::ZeroDuration());
  EXPECT_TRUE(node->Claim(place->mesh.key).ok());
}

TEST_F(PostgresCopyTest, ADatabaseThatAServerUsesIsRefused) {
  {
    const JournalPtr server = Open();
    const absl::Status used = StatusOfOpen(Exclusive());
    EXPECT_TRUE(absl::IsFailedPrecondition(used)) << used;
    EXPECT_TRUE(absl::StrContains(used.message(), "connections of dynmeshd")) << used;
  }
  EXPECT_TRUE(StatusOfOpen(Exclusive()).ok());
}

// A server that is cut off from the database has no connections, and still its leases.
TEST_F(PostgresCopyTest, ADatabaseWithLeasesIsRefusedUntilTheyHaveRunOut) {
  PostgresOptions leased;
  leased.lease = absl::Hours(1);
  {
    const JournalPtr node = Open(leased);
    ASSERT_TRUE(node->Renew("a.example:7878").ok());
    ASSERT_TRUE(node->Create("m", "").ok());
  }
  const absl::Status used = StatusOfOpen(Exclusive());
  EXPECT_TRUE(absl::IsFailedPrecondition(used)) << used;
  EXPECT_TRUE(absl::StrContains(used.message(), "a.example:7878")) << used;
  Sql("UPDATE dynmesh.meshes SET lease_until = clock_timestamp()");
  EXPECT_TRUE(StatusOfOpen(Exclusive()).ok());
}

TEST_F(PostgresCopyTest, ASourceIsNotMade) {
  PostgresOptions options = Exclusive();
  options.make_tables = false;
  const absl::Status none = StatusOfOpen(options);
  EXPECT_TRUE(absl::IsNotFound(none)) << none;
  EXPECT_EQ(Sql("SELECT count(*) FROM pg_namespace WHERE nspname = 'dynmesh'"), "0");
}

// A server that was overlooked, as its connections have another name.
TEST_F(PostgresCopyTest, AServerThatWritesToTheSourceAfterwardsIsFenced) {
  const JournalPtr server = Open();
  const Journal::Key key = JournalFiller(*server, 10).Fill("m", 2, 6, 4);
  const JournalPtr source = Open();
  const auto to = OpenSqlite(folder_.path());
  ASSERT_TRUE(CopyMeshes(*source, *to, {}).ok());
  const absl::Status late = server->Append(key, std::nullopt, Journal::Request{"late", "a"});
  EXPECT_EQ(OutcomeOf(late), AppendOutcome::kFenced) << late;
}

TEST_F(PostgresCopyTest, WhatAnEndLeftBehindIsSweptAtTheNextOpening) {
  {
    const JournalPtr database = Open();
    const auto key = database->NewKey();
    ASSERT_TRUE(key.ok()) << key.status();
    for (int twice = 0; twice < 2; ++twice) {
      const absl::Status written = database->WriteUnseen(*key, {{3, 0, "p"}}, {{4, "a"}, {5, "b"}});
      ASSERT_TRUE(written.ok()) << written;
    }
    EXPECT_TRUE(database->List()->empty());
  }
  EXPECT_EQ(Sql("SELECT count(*) FROM dynmesh.entries"), "2");
  Open().reset();
  EXPECT_EQ(Sql("SELECT (SELECT count(*) FROM dynmesh.entries) + (SELECT count(*) FROM "
                "dynmesh.snapshots)"),
            "0");
}

TEST_F(PostgresCopyTest, PublishIsSafeToRepeatAndNoticesMissingRows) {
  const JournalPtr database = Open();
  const auto key = database->NewKey();
  ASSERT_TRUE(database->WriteUnseen(*key, {}, {{1, "a"}, {2, "b"}}).ok());
  MeshImport::Whole whole{"m", "d", 3, {{0, 0, 0, 2}}, {{"r", "a"}}};
  EXPECT_TRUE(absl::IsFailedPrecondition(database->Publish(*key, whole)));
  whole.head = 2;
  EXPECT_TRUE(database->Publish(*key, whole).ok());
  EXPECT_TRUE(database->Publish(*key, whole).ok()) << "as after an unknown outcome";
  EXPECT_EQ(Told(*database, *key), "?r=a 1:a 2:b ");
  const auto other = database->NewKey();
  whole.head = 0;
  EXPECT_TRUE(absl::IsAlreadyExists(database->Publish(*other, whole)));
}

}  // namespace
}  // namespace dynmesh::server
