// One PostgreSQL server for all tests of a program; each test has a database of its own.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_FIXTURE_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_FIXTURE_H_

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "server/base/log.h"
#include "server/journal/postgres_journal.h"
#include "tests/server/journal/postgres_server.h"

namespace dynmesh::server {

class PostgresTest : public ::testing::Test {
 protected:
  PostgresTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }

  using JournalPtr = std::unique_ptr<PostgresJournal>;
  // `socket`: the folder of the socket that is used instead of the server's.
  JournalPtr Open(const PostgresOptions& options = {}, const std::string& socket = "") {
    auto opened = PostgresJournal::Open(server_.Url(database_, socket), options);
    if (!opened.ok()) throw std::runtime_error(opened.status().ToString());
    return *std::move(opened);
  }
  std::string Sql(const std::string& sql) { return server_.Sql(database_, sql); }

  PostgresServer& server_ = SharedPostgres();
  const std::string database_ = server_.MakeDatabase();
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_POSTGRES_FIXTURE_H_
