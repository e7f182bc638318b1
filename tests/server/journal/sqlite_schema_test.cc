// Files of older versions: made here by hand, as these wrote them.
#include "server/journal/sqlite_schema.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "absl/strings/match.h"
#include "server/base/log.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/told.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server {
namespace {

// Schema 1: mesh a with a snapshot of two parts and entries, b without a snapshot, c with a lost
// snapshot; the highest key belonged to a deleted mesh.
constexpr char kFirst[] = R"(
  PRAGMA journal_mode=WAL;
  CREATE TABLE meshes(
    key INTEGER PRIMARY KEY AUTOINCREMENT,
    id TEXT NOT NULL UNIQUE,
    description BLOB NOT NULL,
    snapshot INTEGER NOT NULL,  -- its revision
    head INTEGER NOT NULL);     -- the last entry's, or the snapshot's
  CREATE TABLE snapshots(
    mesh INTEGER NOT NULL, part INTEGER NOT NULL, data BLOB NOT NULL,
    PRIMARY KEY(mesh, part)) WITHOUT ROWID;
  CREATE TABLE entries(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, data BLOB NOT NULL,
    PRIMARY KEY(mesh, revision)) WITHOUT ROWID;
  CREATE TABLE requests(
    mesh INTEGER NOT NULL, number INTEGER NOT NULL, id TEXT NOT NULL, answer BLOB NOT NULL,
    PRIMARY KEY(mesh, number)) WITHOUT ROWID;
  CREATE TABLE probes(number INTEGER PRIMARY KEY);
  INSERT INTO probes VALUES(0);
  INSERT INTO meshes VALUES(1, 'a', CAST('about a' AS BLOB), 7, 9);
  INSERT INTO meshes VALUES(2, 'b', CAST('' AS BLOB), 0, 1);
  INSERT INTO meshes VALUES(3, 'c', CAST('' AS BLOB), 4, 4);
  INSERT INTO meshes VALUES(6, 'd', CAST('' AS BLOB), 0, 0);
  DELETE FROM meshes WHERE key = 6;
  INSERT INTO snapshots VALUES(1, 0, CAST('p' AS BLOB)), (1, 1, CAST('q' AS BLOB));
  INSERT INTO entries VALUES(1, 8, CAST('e8' AS BLOB)), (1, 9, CAST('e9' AS BLOB));
  INSERT INTO entries VALUES(2, 1, x'');
  INSERT INTO requests VALUES(1, 3, 'r3', CAST('A3' AS BLOB)), (1, 4, 'r4', x'');
  PRAGMA user_version = 1;
)";

class SqliteSchemaTest : public ::testing::Test {
 protected:
  SqliteSchemaTest() {
    EXPECT_TRUE(SetLogLevel("off").ok());
    auto db = *sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    const absl::Status made = db.Run(kFirst);
    EXPECT_TRUE(made.ok()) << made;
  }
  std::string SchemaOf(const std::string& folder) {
    auto db = *sqlite::Connection::Open(folder + "/journal.sqlite", nullptr);
    sqlite::Statement rows(db, "SELECT sql FROM sqlite_schema WHERE type = 'table' ORDER BY name");
    std::string text;
    while (rows.Step()) text += rows.Bytes(0) + "\n";
    return text;
  }

  test::TempFolder folder_;
};

TEST_F(SqliteSchemaTest, AFileOfTheFirstVersionGoesOn) {
  for (int i = 0; i < 2; ++i) {
    const auto journal = SqliteJournal::Open(folder_.path(), {});
    ASSERT_TRUE(journal.ok()) << journal.status();
    Journal& j = **journal;
    const auto meshes = j.List();
    ASSERT_TRUE(meshes.ok() && meshes->size() == 3u) << meshes.status();
    EXPECT_EQ((*meshes)[0].description, "about a");
    EXPECT_TRUE((*meshes)[0].damage.ok());
    EXPECT_EQ((*meshes)[0].entries, 3u);
    EXPECT_EQ(Told(j, 1), "?r3=A3 ?r4= @7:p @7:q 8:e8 9:e9 ");
    EXPECT_EQ(Told(j, 2), "1: ");
    EXPECT_TRUE(absl::StrContains(Told(j, 3), "mesh c the snapshot of revision 4")) << Told(j, 3);
    EXPECT_EQ(*j.Oldest(1), 7u);
    EXPECT_EQ(ToldPast(j, 1, 8, 8), "@7:p @7:q 8:e8 ");
    EXPECT_TRUE(absl::StrContains(ToldPast(j, 1, 6, 6), "OUT_OF_RANGE"));
    EXPECT_EQ(*j.Oldest(2), 0u);
  }
  const auto journal = SqliteJournal::Open(folder_.path(), {});
  Journal& j = **journal;
  EXPECT_GT(*j.Create("e", ""), 6) << "keys are never given again";
  ASSERT_TRUE(j.Append(1, Journal::Entry{10, "e10"}, std::nullopt).ok());
  ASSERT_TRUE(j.Compact(1, 10, {"s"}).ok());
  EXPECT_EQ(ToldPast(j, 1, 9, 10), "@7:p @7:q 8:e8 9:e9 10:e10 ");
}

// Schema 9 has the same tables, and no labels.
TEST_F(SqliteSchemaTest, AFileBeforeLabelsGoesOn) {
  ASSERT_TRUE(SqliteJournal::Open(folder_.path(), {}).ok());
  const auto version = [&](const char* sql) {
    auto db = *sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    sqlite::Statement row(db, sql);
    return row.Step() ? row.Integer(0) : 0;
  };
  version("PRAGMA user_version = 9");
  ASSERT_EQ(version("PRAGMA user_version"), 9);
  const std::string before = SchemaOf(folder_.path());
  {
    const auto journal = SqliteJournal::Open(folder_.path(), {});
    ASSERT_TRUE(journal.ok()) << journal.status();
    EXPECT_EQ(Told(**journal, 1), "?r3=A3 ?r4= @7:p @7:q 8:e8 9:e9 ");
  }
  EXPECT_EQ(version("PRAGMA user_version"), kJournalSchema);
  EXPECT_EQ(SchemaOf(folder_.path()), before);
  EXPECT_FALSE(CheckJournalSchema(kJournalSchema + 1).ok());
}

TEST_F(SqliteSchemaTest, ANewFileHasTheSameTables) {
  test::TempFolder fresh;
  ASSERT_TRUE(SqliteJournal::Open(folder_.path(), {}).ok());
  ASSERT_TRUE(SqliteJournal::Open(fresh.path(), {}).ok());
  const auto columns = [](const std::string& folder) {
    auto db = *sqlite::Connection::Open(folder + "/journal.sqlite", nullptr);
    sqlite::Statement rows(
        db,
        "SELECT t.name || '.' || c.name || ' ' || c.type || c.pk || c.\"notnull\" FROM "
        "sqlite_schema AS t, pragma_table_info(t.name) AS c WHERE t.type = 'table' ORDER BY 1");
    std::string text;
    while (rows.Step()) text += rows.Bytes(0) + "\n";
    return text;
  };
  EXPECT_TRUE(absl::StrContains(columns(fresh.path()), "generations.parts"));
  EXPECT_EQ(columns(folder_.path()), columns(fresh.path()));
}

// A file that cannot be upgraded is unchanged.
TEST_F(SqliteSchemaTest, AnUpgradeThatFailsChangesNothing) {
  {
    auto db = *sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    ASSERT_TRUE(db.Run("CREATE TABLE old_snapshots(x)").ok());  // in the way
  }
  const std::string before = SchemaOf(folder_.path());
  EXPECT_FALSE(SqliteJournal::Open(folder_.path(), {}).ok());
  EXPECT_EQ(SchemaOf(folder_.path()), before);
  {
    auto db = *sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    ASSERT_TRUE(db.Run("DROP TABLE old_snapshots").ok());
  }
  const auto journal = SqliteJournal::Open(folder_.path(), {});
  ASSERT_TRUE(journal.ok()) << journal.status();
  EXPECT_EQ(Told(**journal, 2), "1: ");
}

}  // namespace
}  // namespace dynmesh::server
