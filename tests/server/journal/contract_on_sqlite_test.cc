// The guarantees of every journal, for the one in SQLite.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/journal_contract.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server {
namespace {

class SqliteBackend final : public JournalBackend {
 public:
  absl::StatusOr<std::unique_ptr<Journal>> Open(const Options& given) override {
    SqliteJournal::Options options;
    options.remembered_requests = given.remembered_requests;
    options.history_bytes = given.history_bytes;
    options.transaction_bytes = given.transaction_bytes;
    return SqliteJournal::Open(folder_.path(), options);
  }
  void Run(const std::string& sql) override {
    auto db = *sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    ASSERT_TRUE(db.Run(sql.c_str()).ok());
  }
  std::int64_t Rows(const std::string& table) override {
    auto db = *sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    const std::string sql = "SELECT count(*) FROM " + table;
    sqlite::Statement count(db, sql.c_str());
    return count.Step() ? count.Integer(0) : -1;
  }

 private:
  test::TempFolder folder_;
};

const BackendKind kSqlite = {"sqlite", [] { return std::make_unique<SqliteBackend>(); }};
INSTANTIATE_TEST_SUITE_P(Sqlite, JournalTest, ::testing::Values(kSqlite));
INSTANTIATE_TEST_SUITE_P(Sqlite, JournalGenerationsTest, ::testing::Values(kSqlite));

}  // namespace
}  // namespace dynmesh::server
