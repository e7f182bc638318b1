// The history in a journal: what is kept and what is deleted, also after an interruption.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/journal/sqlite_generations.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/durable_registry.h"
#include "tests/server/journal/failing_vfs.h"
#include "tests/server/journal/told.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;

// Rows of a table in the files, also of those that no reader sees.
std::int64_t Rows(const std::string& folder, const std::string& table) {
  auto db = *sqlite::Connection::Open(folder + "/journal.sqlite", nullptr);
  const std::string sql = "SELECT count(*) FROM " + table;
  sqlite::Statement count(db, sql.c_str());
  return count.Step() ? count.Integer(0) : -1;
}

class GenerationsTest : public ::testing::Test {
 protected:
  GenerationsTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }
  ~GenerationsTest() override { FailingVfs::Heal(); }

  void Open(const SqliteJournal::Options& options = {}) {
    journal_.reset();
    auto opened = SqliteJournal::Open(folder_.path(), options);
    ASSERT_TRUE(opened.ok()) << opened.status();
    journal_ = *std::move(opened);
  }
  void Append(Journal::Key key, std::uint64_t revision, const std::string& data) {
    const absl::Status status = journal_->Append(key, Entry{revision, data}, std::nullopt);
    ASSERT_TRUE(status.ok()) << status;
  }

  test::TempFolder folder_;
  std::unique_ptr<SqliteJournal> journal_;
};

// Snapshots and a deletion in parts, with each write failing in turn, permanently, as a crash
// would. Then the journal has the old or the new state, and the next opening deletes the leftovers.
TEST_F(GenerationsTest, CutShortAnywhereLeaveAValidStateAndNoRows) {
  SqliteJournal::Options options;
  options.vfs = FailingVfs::Name();
  options.transaction_bytes = 10;
  options.history_bytes = 0;
  const std::vector<std::string> parts = {"part-zero", "part-one", "part-two"};
  const std::string before = "@2:s 3:three 4:four 5:five ";
  const std::string after = "@4:part-zero @4:part-one @4:part-two 5:five ";
  int at = 1;
  int before_seen = 0, after_seen = 0, swept = 0;
  for (;; ++at) {
    SCOPED_TRACE(absl::StrCat("operation ", at));
    journal_.reset();
    std::filesystem::remove_all(folder_.path());
    Open(options);
    const auto a = *journal_->Create("a", ""), b = *journal_->Create("b", "");
    Append(a, 1, "one");
    Append(a, 2, "two");
    ASSERT_TRUE(journal_->Compact(a, 2, {"s"}).ok());
    Append(a, 3, "three");
    Append(a, 4, "four");
    Append(a, 5, "five");
    for (std::uint64_t r = 1; r <= 4; ++r) Append(b, r, "an entry of b");
    FailingVfs::FailAt(at, /*ever=*/true);
    const absl::Status compacted = journal_->Compact(a, 4, parts);
    const absl::Status deleted = journal_->Delete(b);
    while (deleted.ok() && journal_->Sweep(b)) {
    }
    // A failure may be unreported: then only leftovers were to be swept.
    const bool failed = FailingVfs::failures() > 0;

    test::TempFolder copy;
    CopyJournal(folder_.path(), copy.path());
    const std::int64_t left = Rows(copy.path(), "snapshots") + Rows(copy.path(), "entries");
    const auto crashed = SqliteJournal::Open(copy.path(), {});
    ASSERT_TRUE(crashed.ok()) << crashed.status();
    const std::string told = Told(**crashed, a);
    ASSERT_TRUE(told == before || told == after) << told;
    (told == before ? before_seen : after_seen)++;
    ASSERT_TRUE(!compacted.ok() || told == after);
    const bool b_there = (*crashed)->List()->size() == 2;
    ASSERT_TRUE(!deleted.ok() || !b_there);
    ASSERT_EQ(Rows(copy.path(), "snapshots"), told == before ? 1 : 4);
    ASSERT_EQ(Rows(copy.path(), "entries"), (told == before ? 5 : 3) + (b_there ? 4 : 0));
    swept += left > Rows(copy.path(), "snapshots") + Rows(copy.path(), "entries");

    FailingVfs::Heal();
    const absl::Status again = journal_->Compact(a, 4, parts);
    ASSERT_TRUE(again.ok()) << again;
    ASSERT_EQ(Told(*journal_, a), after);
    ASSERT_EQ(ToldPast(*journal_, a, 3, 3), "@2:s 3:three ");
    ASSERT_EQ(Rows(folder_.path(), "snapshots"), 4);
    if (!failed) break;
  }
  EXPECT_GT(at, 15);
  EXPECT_GT(before_seen, 5);
  EXPECT_GT(after_seen, 5);
  EXPECT_GT(swept, 5);
}

}  // namespace
}  // namespace dynmesh::server
