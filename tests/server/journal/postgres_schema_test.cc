// The versions of the tables in PostgreSQL: which are read, and how a step leads to the next one.
#include "server/journal/postgres_schema.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/journal/postgres_target.h"
#include "tests/server/journal/postgres_fixture.h"

namespace dynmesh::server {
namespace {

class PostgresSchemaTest : public PostgresTest {
 protected:
  // As a program that has a further step, with the user that `query` names.
  absl::Status PrepareWith(const char* step, const std::string& query = "") {
    const auto target = postgres::ParseTarget(absl::StrCat(server_.Url(database_), query));
    auto session = postgres::Session::Connect(target->conninfo);
    if (!session.ok()) return session.status();
    const Schemas& real = postgres::SchemasOfDatabases();
    std::vector<const char*> steps(real.steps.begin(), real.steps.end());
    steps.push_back(step);
    return postgres::PrepareSchema(**session, {real.first, real.tables, steps, real.store});
  }
};

TEST_F(PostgresSchemaTest, ANewDatabaseHasThePresentOne) {
  ASSERT_NE(Open(), nullptr);
  EXPECT_EQ(Sql("SELECT version FROM dynmesh.journal"), absl::StrCat(postgres::kPostgresSchema));
  EXPECT_EQ(postgres::SchemasOfDatabases().present(), postgres::kPostgresSchema);
}

TEST_F(PostgresSchemaTest, AVersionBeforeTheFirstIsRefusedAndStays) {
  ASSERT_NE(Open(), nullptr);
  Sql("UPDATE dynmesh.journal SET version = 2");
  const absl::Status status = OpenPostgresJournal(server_.Url(database_), {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_TRUE(absl::StrContains(status.message(), "schema 2, the oldest")) << status;
  EXPECT_TRUE(absl::StrContains(status.message(), "save each mesh's features")) << status;
  EXPECT_EQ(Sql("SELECT version FROM dynmesh.journal"), "2");
}

// No step of the program changes a table yet, so one is made up.
TEST_F(PostgresSchemaTest, AStepLeadsToTheNextVersionAndKeepsAllRows) {
  ASSERT_TRUE(Open()->Create("m", "about m").ok());
  constexpr char kStep[] = "ALTER TABLE dynmesh.meshes ADD COLUMN colour TEXT DEFAULT 'red';";
  for (int i = 0; i < 2; ++i) {  // the second time there is nothing to do
    EXPECT_TRUE(PrepareWith(kStep).ok());
    EXPECT_EQ(Sql("SELECT version FROM dynmesh.journal"),
              absl::StrCat(postgres::kPostgresSchema + 1));
    EXPECT_EQ(Sql("SELECT id || ' ' || colour FROM dynmesh.meshes"), "m red");
  }
  const absl::Status newer = OpenPostgresJournal(server_.Url(database_), {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(newer)) << newer;
  Sql("DROP SCHEMA dynmesh CASCADE");
  EXPECT_TRUE(PrepareWith(kStep).ok());  // of a new database, too
  EXPECT_EQ(Sql("SELECT count(colour) FROM dynmesh.meshes"), "0");
}

TEST_F(PostgresSchemaTest, AStepThatFailsChangesNothing) {
  ASSERT_NE(Open(), nullptr);
  EXPECT_FALSE(PrepareWith("ALTER TABLE dynmesh.meshes ADD COLUMN colour TEXT; "
                           "DROP TABLE dynmesh.not_there;")
                   .ok());
  EXPECT_EQ(Sql("SELECT version FROM dynmesh.journal"), absl::StrCat(postgres::kPostgresSchema));
  EXPECT_EQ(Sql("SELECT count(*) FROM information_schema.columns WHERE column_name = 'colour'"),
            "0");
  EXPECT_NE(Open(), nullptr);
}

TEST_F(PostgresSchemaTest, AnUpgradeWithoutTheRightToItIsNamed) {
  Sql("DO $$ BEGIN CREATE ROLE guest LOGIN; EXCEPTION WHEN duplicate_object THEN END $$");
  ASSERT_NE(Open(), nullptr);
  Sql("GRANT USAGE ON SCHEMA dynmesh TO guest; GRANT SELECT ON ALL TABLES IN SCHEMA dynmesh TO "
      "guest");
  // Of a step that changes the version alone.
  const absl::Status status = PrepareWith("", "?user=guest");
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_TRUE(absl::StrContains(status.message(), "GRANT UPDATE ON dynmesh.journal")) << status;
  EXPECT_EQ(Sql("SELECT version FROM dynmesh.journal"), absl::StrCat(postgres::kPostgresSchema));
}

TEST_F(PostgresSchemaTest, ANewerSchemaIsRefused) {
  ASSERT_NE(Open(), nullptr);
  Sql("UPDATE dynmesh.journal SET version = 99");
  const absl::Status status = OpenPostgresJournal(server_.Url(database_), {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_TRUE(absl::StrContains(status.message(), "schema 99")) << status;
}

}  // namespace
}  // namespace dynmesh::server
