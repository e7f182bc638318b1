// The schemas of the journal in SQLite: which are read, and how a step leads to the next one. No
// step of the program changes a table yet, so one is made up here.
#include "server/journal/sqlite_schema.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/told.h"
#include "tests/support/source_path.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::sqlite_schema_test {
namespace {

constexpr char kStep[] = "ALTER TABLE meshes ADD COLUMN colour TEXT NOT NULL DEFAULT 'red';";
constexpr char kStepThatFails[] =
    "ALTER TABLE meshes ADD COLUMN colour TEXT; DROP TABLE not_there;";

// Those of a program that has a further step. They stand until the next call.
Schemas With(const char* step) {
  const Schemas& real = SchemasOfJournals();
  static std::vector<const char*> steps;
  steps.assign(real.steps.begin(), real.steps.end());
  steps.push_back(step);
  return {real.first, real.tables, steps, real.store};
}

class SqliteSchemaTest : public ::testing::Test {
 protected:
  SqliteSchemaTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }

  // A journal with a mesh that has a snapshot and an entry.
  void MakeJournal() {
    const auto journal = SqliteJournal::Open(folder_.path(), {});
    ASSERT_TRUE(journal.ok()) << journal.status();
    Journal& j = **journal;
    key_ = *j.Create("a", "about a");
    ASSERT_TRUE(j.Append(key_, Journal::Entry{1, "e1"}, std::nullopt).ok());
    ASSERT_TRUE(j.Compact(key_, 1, {"p", "q"}).ok());
    ASSERT_TRUE(j.Append(key_, Journal::Entry{2, "e2"}, std::nullopt).ok());
  }
  absl::Status OpenStatus() { return SqliteJournal::Open(folder_.path(), {}).status(); }
  sqlite::Connection Connect() { return Connect(folder_.path() + "/journal.sqlite"); }
  static sqlite::Connection Connect(const std::string& path) {
    return *sqlite::Connection::Open(path, nullptr);
  }
  // The rows of a query, one a line.
  static std::string Rows(sqlite::Connection& db, const char* sql) {
    sqlite::Statement rows(db, sql);
    std::string text;
    while (rows.Step()) text += rows.Bytes(0) + "\n";
    EXPECT_TRUE(rows.status().ok()) << rows.status();
    return text;
  }
  std::string SchemaNumber() {
    auto db = Connect();
    return Rows(db, "PRAGMA user_version");
  }
  void SetSchemaNumber(int schema) {
    auto db = Connect();
    ASSERT_TRUE(db.Run(absl::StrCat("PRAGMA user_version = ", schema).c_str()).ok());
  }
  // Names, types and defaults of all columns, and what else a table says of itself.
  static std::string Tables(sqlite::Connection& db) {
    return Rows(db,
                "SELECT t.name || '.' || c.cid || ' ' || c.name || ' ' || c.type || c.pk || "
                "c.\"notnull\" || ifnull(c.dflt_value, '') || (t.sql LIKE '%WITHOUT ROWID') || "
                "(t.sql LIKE '%AUTOINCREMENT%') || (t.sql LIKE '%UNIQUE%') FROM sqlite_schema AS "
                "t, pragma_table_info(t.name) AS c WHERE t.type = 'table' ORDER BY 1");
  }

  test::TempFolder folder_;
  Journal::Key key_ = 0;
};

// The file is one that dynmeshd wrote when the tables were still made in three steps.
TEST_F(SqliteSchemaTest, ANewJournalHasTheTablesOfEarlierFiles) {
  MakeJournal();
  auto earlier = Connect(test::SourcePath("tests/e2e/journals/bits1-backup.sqlite"));
  auto now = Connect();
  EXPECT_TRUE(absl::StrContains(Tables(now), "generations.2 parts"));
  EXPECT_EQ(Tables(now), Tables(earlier));
  EXPECT_EQ(SchemaNumber(), absl::StrCat(kJournalSchema, "\n"));
  EXPECT_EQ(SchemasOfJournals().present(), kJournalSchema);
}

TEST_F(SqliteSchemaTest, ASchemaBeforeTheFirstIsRefusedAndStays) {
  MakeJournal();
  for (const int schema : {1, SchemasOfJournals().first - 1}) {
    SetSchemaNumber(schema);
    const absl::Status refused = OpenStatus();
    EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
    EXPECT_TRUE(absl::StrContains(refused.message(), absl::StrCat("schema ", schema, ", the ")))
        << refused;
    EXPECT_TRUE(absl::StrContains(refused.message(), "save each mesh's features")) << refused;
    EXPECT_EQ(SchemaNumber(), absl::StrCat(schema, "\n"));
  }
  SetSchemaNumber(kJournalSchema);
  EXPECT_TRUE(OpenStatus().ok());
}

TEST_F(SqliteSchemaTest, AFileOfAnotherProgramIsRefusedAndStays) {
  std::string before;
  {
    auto db = Connect();
    ASSERT_TRUE(db.Run("CREATE TABLE recipes(name TEXT)").ok());
    before = Tables(db);
  }
  const absl::Status refused = OpenStatus();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_TRUE(absl::StrContains(refused.message(), "no journal")) << refused;
  auto db = Connect();
  EXPECT_EQ(Tables(db), before);
}

TEST_F(SqliteSchemaTest, AStepLeadsToTheNextSchemaAndKeepsAllRows) {
  MakeJournal();
  const Schemas next = With(kStep);
  EXPECT_EQ(next.present(), kJournalSchema + 1);
  for (int i = 0; i < 2; ++i) {  // the second time there is nothing to do
    auto db = Connect();
    const absl::Status upgraded = PrepareJournal(db, folder_.path(), "", next);
    ASSERT_TRUE(upgraded.ok()) << upgraded;
    EXPECT_EQ(Rows(db, "SELECT id || ' ' || colour FROM meshes"), "a red\n");
    EXPECT_EQ(Rows(db, "SELECT count(*) FROM journal"), "1\n") << "the id is the former one";
  }
  EXPECT_EQ(SchemaNumber(), absl::StrCat(kJournalSchema + 1, "\n"));
  const absl::Status newer = OpenStatus();
  EXPECT_TRUE(absl::IsFailedPrecondition(newer)) << newer;
  // The column is one that this program does not look at.
  SetSchemaNumber(kJournalSchema);
  const auto journal = SqliteJournal::Open(folder_.path(), {});
  ASSERT_TRUE(journal.ok()) << journal.status();
  EXPECT_EQ(Told(**journal, key_), "@1:p @1:q 2:e2 ");
}

TEST_F(SqliteSchemaTest, ANewFileHasTheTablesOfAnUpgradedOne) {
  MakeJournal();
  auto upgraded = Connect();
  ASSERT_TRUE(PrepareJournal(upgraded, folder_.path(), "", With(kStep)).ok());
  test::TempFolder fresh;
  auto made = Connect(fresh.path() + "/journal.sqlite");
  ASSERT_TRUE(PrepareJournal(made, fresh.path(), "id", With(kStep)).ok());
  EXPECT_TRUE(absl::StrContains(Tables(made), "colour"));
  EXPECT_EQ(Tables(made), Tables(upgraded));
  EXPECT_EQ(Rows(made, "PRAGMA user_version"), Rows(upgraded, "PRAGMA user_version"));
}

TEST_F(SqliteSchemaTest, AStepThatFailsChangesNothing) {
  MakeJournal();
  std::string before;
  {
    auto db = Connect();
    before = Tables(db);
    EXPECT_FALSE(PrepareJournal(db, folder_.path(), "", With(kStepThatFails)).ok());
  }
  auto db = Connect();
  EXPECT_EQ(Tables(db), before);
  EXPECT_EQ(SchemaNumber(), absl::StrCat(kJournalSchema, "\n"));
  EXPECT_TRUE(OpenStatus().ok());
}

}  // namespace
}  // namespace dynmesh::server::sqlite_schema_test
