// The guarantees of every journal, for the one in PostgreSQL.
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "tests/server/journal/journal_contract.h"
#include "tests/server/journal/postgres_fixture.h"

namespace dynmesh::server {
namespace {

class PostgresBackend final : public JournalBackend {
 public:
  absl::StatusOr<std::unique_ptr<Journal>> Open(const Options& given) override {
    PostgresOptions options;
    options.remembered_requests = given.remembered_requests;
    options.history_bytes = given.history_bytes;
    options.transaction_bytes = given.transaction_bytes;
    return OpenPostgresJournal(SharedPostgres().Url(database_), options);
  }
  void Run(const std::string& sql) override {
    SharedPostgres().Sql(database_, "SET search_path = dynmesh; " + sql);
  }
  std::int64_t Rows(const std::string& table) override {
    return std::atoll(
        SharedPostgres().Sql(database_, "SELECT count(*) FROM dynmesh." + table).c_str());
  }

 private:
  const std::string database_ = SharedPostgres().MakeDatabase();
};

const BackendKind kPostgres = {"postgres", [] { return std::make_unique<PostgresBackend>(); }};
INSTANTIATE_TEST_SUITE_P(Postgres, JournalTest, ::testing::Values(kPostgres));
INSTANTIATE_TEST_SUITE_P(Postgres, JournalGenerationsTest, ::testing::Values(kPostgres));

}  // namespace
}  // namespace dynmesh::server
