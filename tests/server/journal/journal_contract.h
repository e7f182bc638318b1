// What every journal guarantees, as tests with a parameter: how a kind of journal is made. A
// program that links journal_contract_test.cc and generations_contract_test.cc instantiates both
// suites.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_JOURNAL_CONTRACT_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_JOURNAL_CONTRACT_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include "server/base/log.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

// A place for one journal, with access to its rows past the journal.
class JournalBackend {
 public:
  struct Options {
    std::size_t remembered_requests = 10'000;
    std::uint64_t history_bytes = 64 << 20, transaction_bytes = 4 << 20;
  };

  virtual ~JournalBackend() = default;
  virtual absl::StatusOr<std::unique_ptr<Journal>> Open(const Options& options) = 0;
  virtual void Run(const std::string& sql) = 0;
  // Rows of a table, also of those that no reader sees.
  virtual std::int64_t Rows(const std::string& table) = 0;
};

// A kind of journal, by its name in the names of tests.
struct BackendKind {
  const char* name;
  std::function<std::unique_ptr<JournalBackend>()> make;

  friend void PrintTo(const BackendKind& kind, std::ostream* out) { *out << kind.name; }
};

class JournalTest : public ::testing::TestWithParam<BackendKind> {
 protected:
  JournalTest() : backend_(GetParam().make()) { EXPECT_TRUE(SetLogLevel("off").ok()); }

  // Opens the journal again, and claims its meshes.
  void Open(const JournalBackend::Options& options = {}) {
    journal_.reset();
    auto opened = backend_->Open(options);
    ASSERT_TRUE(opened.ok()) << opened.status();
    journal_ = *std::move(opened);
    const auto meshes = journal_->List();
    ASSERT_TRUE(meshes.ok()) << meshes.status();
    for (const Journal::Mesh& mesh : *meshes) ASSERT_TRUE(journal_->Claim(mesh.key).ok());
  }
  // In another, empty place.
  void OpenFresh(const JournalBackend::Options& options = {}) {
    journal_.reset();
    backend_ = GetParam().make();
    Open(options);
  }
  void Append(Journal::Key key, std::uint64_t revision, const std::string& data) {
    const absl::Status status = journal_->Append(key, Journal::Entry{revision, data}, std::nullopt);
    ASSERT_TRUE(status.ok()) << status;
  }

  std::unique_ptr<JournalBackend> backend_;
  std::unique_ptr<Journal> journal_;
};

// Of snapshots and history.
class JournalGenerationsTest : public JournalTest {};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_JOURNAL_CONTRACT_H_
