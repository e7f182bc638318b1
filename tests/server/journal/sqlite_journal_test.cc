// The guarantees of a journal, for the one in SQLite: by itself, on a failing disk, with old, new
// and broken files.
#include "server/journal/sqlite_journal.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/journal/sqlite_schema.h"
#include "tests/server/journal/durable_registry.h"
#include "tests/server/journal/failing_vfs.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;
using Request = Journal::Request;

class SqliteJournalTest : public ::testing::Test {
 protected:
  SqliteJournalTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }
  ~SqliteJournalTest() override { FailingVfs::Heal(); }

  void Open(const SqliteJournal::Options& options = {}) {
    journal_.reset();
    auto opened = SqliteJournal::Open(folder_.path(), options);
    ASSERT_TRUE(opened.ok()) << opened.status();
    journal_ = *std::move(opened);
  }
  void OpenFailing() {
    SqliteJournal::Options options;
    options.vfs = FailingVfs::Name();
    Open(options);
  }
  std::string File() const { return folder_.path() + "/journal.sqlite"; }

  test::TempFolder folder_;
  std::unique_ptr<SqliteJournal> journal_;
};

TEST_F(SqliteJournalTest, BatchesThatComeTogetherShareASyncAndFailTogether) {
  OpenFailing();
  const auto key = *journal_->Create("a", "");
  const std::vector<Entry> three = {{1, "one"}, {2, "two"}, {3, "three"}};
  const std::vector<Request> two = {{"r1", "A1"}, {"r3", "A3"}};
  FailingVfs::FailAt(1, /*ever=*/false);
  EXPECT_TRUE(absl::IsUnavailable(journal_->Append(key, three, two)));
  EXPECT_EQ(Told(*journal_, key), "");
  // None if one of them does not follow.
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Append(key, {{1, "one"}, {3, "three"}}, two)));
  EXPECT_TRUE(absl::IsFailedPrecondition(journal_->Append(key, {{2, "two"}}, two)));
  EXPECT_EQ(Told(*journal_, key), "");
  const std::uint64_t before = journal_->counts().syncs;
  ASSERT_TRUE(journal_->Append(key, three, two).ok());
  EXPECT_EQ(journal_->counts().syncs, before + 1);
  EXPECT_EQ(Told(*journal_, key), "?r1=A1 ?r3=A3 1:one 2:two 3:three ");
  ASSERT_TRUE(journal_->Append(key, {{4, "four"}}, std::vector<Request>()).ok());
  EXPECT_EQ(ToldPast(*journal_, key, 2, 4), "1:one 2:two 3:three 4:four ");
  ASSERT_TRUE(journal_->Compact(key, 4, {"p"}).ok());
  EXPECT_EQ(Told(*journal_, key), "?r1=A1 ?r3=A3 @4:p ");
}

// Far more than the log should have, from many threads, so that almost always one writes.
TEST_F(SqliteJournalTest, TheLogIsMovedIntoTheDatabaseAndBeginsAnew) {
  Open();
  constexpr int kWriters = 4, kEntries = 2'500;
  const std::string data(4'000, 'x');
  std::vector<std::thread> writers;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      const auto key = journal_->Create(absl::StrCat("m", w), "");
      ASSERT_TRUE(key.ok());
      for (std::uint64_t r = 1; r <= kEntries; ++r) {
        ASSERT_TRUE(journal_->Append(*key, Entry{r, data}, std::nullopt).ok());
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  const auto size = [&](const char* end) { return std::filesystem::file_size(File() + end); };
  constexpr std::uint64_t kPage = 4'096, kAll = std::uint64_t{kWriters} * kEntries * 4'000;
  static_assert(2 * kPage * Checkpointer::kFarTooMany < kAll);
  EXPECT_LT(size("-wal"), 2 * kPage * Checkpointer::kFarTooMany);
  EXPECT_GT(size(""), kAll / 2);
  Open();
  const auto meshes = journal_->List();
  ASSERT_TRUE(meshes.ok());
  for (const Journal::Mesh& mesh : *meshes) EXPECT_EQ(mesh.entries, kEntries + 0u) << mesh.id;
}

TEST_F(SqliteJournalTest, TheFolderBelongsToOne) {
  Open();
  const absl::Status second = SqliteJournal::Open(folder_.path(), {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(second));
  EXPECT_TRUE(absl::StrContains(second.message(), absl::StrCat("process ", getpid()))) << second;
  journal_.reset();
  EXPECT_TRUE(SqliteJournal::Open(folder_.path(), {}).ok());
}

TEST_F(SqliteJournalTest, WhatItMakesIsForItsUserOnly) {
  namespace fs = std::filesystem;
  constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;
  const std::string folder = folder_.path() + "/new/folder";
  auto journal = *SqliteJournal::Open(folder, {});
  ASSERT_TRUE(journal->Create("a", "").ok());
  EXPECT_EQ(fs::status(folder).permissions() & kOthers, fs::perms::none);
  for (const char* file : {"journal.sqlite", "journal.sqlite-wal", "journal.sqlite-shm"}) {
    EXPECT_EQ(fs::status(folder + "/" + file).permissions() & kOthers, fs::perms::none) << file;
  }
  EXPECT_GT(journal->bytes(), fs::file_size(folder + "/journal.sqlite"));
}

TEST_F(SqliteJournalTest, ABackupUnderAnotherNameIsNotPassedOverInSilence) {
  ASSERT_TRUE(SetLogLevel("warning").ok());
  std::ofstream(folder_.path() + "/backup.sqlite") << "x";
  testing::internal::CaptureStderr();
  Open();
  const std::string first = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(absl::StrContains(first, "event=journal_made")) << first;
  EXPECT_TRUE(absl::StrContains(first, "others=backup.sqlite")) << first;
  testing::internal::CaptureStderr();
  Open();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// As in the runbook, while others write.
TEST_F(SqliteJournalTest, ABackupMadeUnderLoadIsAMomentOfIt) {
  Open();
  const auto key = *journal_->Create("a", "");
  std::atomic<std::uint64_t> acknowledged{0};
  std::atomic<bool> end{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; !end; ++i) {
      EXPECT_TRUE(journal_->Append(key, Entry{i, std::to_string(i)}, std::nullopt).ok());
      acknowledged = i;
    }
  });
  for (int i = 0; i < 3; ++i) {
    const std::string folder = absl::StrCat(folder_.path(), "/backup", i);
    std::filesystem::create_directory(folder);
    test::WaitUntil("appends", [&] { return acknowledged >= 20u * static_cast<unsigned>(i + 1); });
    const std::uint64_t before = acknowledged;
    auto other = *sqlite::Connection::Open(File(), nullptr);
    const absl::Status made =
        other.Run(absl::StrCat("VACUUM INTO '", folder, "/journal.sqlite'").c_str());
    EXPECT_TRUE(made.ok()) << made;
    const std::uint64_t after = acknowledged + 1;
    auto backup = *SqliteJournal::Open(folder, {});
    const auto meshes = *backup->List();
    ASSERT_EQ(meshes.size(), 1u);
    EXPECT_TRUE(meshes[0].damage.ok());
    EXPECT_GE(meshes[0].entries, before);
    EXPECT_LE(meshes[0].entries, after + 1);
    std::string wanted;
    for (std::uint64_t r = 1; r <= meshes[0].entries; ++r) absl::StrAppend(&wanted, r, ":", r, " ");
    EXPECT_EQ(Told(*backup, meshes[0].key), wanted);
  }
  end = true;
  writer.join();
}

TEST_F(SqliteJournalTest, ANewerSchemaIsRefused) {
  Open();
  journal_.reset();
  {
    auto db = *sqlite::Connection::Open(File(), nullptr);
    ASSERT_TRUE(db.Run(absl::StrCat("PRAGMA user_version = ", kJournalSchema + 1).c_str()).ok());
  }
  const absl::Status refused = SqliteJournal::Open(folder_.path(), {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused));
  EXPECT_TRUE(absl::StrContains(refused.message(), absl::StrCat("schema ", kJournalSchema + 1)))
      << refused;
}

TEST_F(SqliteJournalTest, AFileThatIsNoDatabaseIsRefused) {
  std::ofstream(File()) << std::string(10'000, 'x');
  EXPECT_TRUE(absl::IsDataLoss(SqliteJournal::Open(folder_.path(), {}).status()));
}

TEST_F(SqliteJournalTest, AfterAFailedWriteNothingIsWrittenUntilAProbeWas) {
  OpenFailing();
  const auto key = *journal_->Create("a", "");
  ASSERT_TRUE(journal_->Append(key, Entry{1, "x"}, std::nullopt).ok());
  FailingVfs::FailAt(1, /*ever=*/true);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(absl::IsUnavailable(journal_->Append(key, Entry{2, "y"}, std::nullopt)));
    EXPECT_TRUE(absl::IsUnavailable(journal_->Create("b", "").status()));
    EXPECT_EQ(Told(*journal_, key), "1:x ");  // reading goes on
    EXPECT_TRUE(journal_->counts().failing);
  }
  FailingVfs::Heal();
  EXPECT_TRUE(journal_->Append(key, Entry{2, "z"}, std::nullopt).ok());
  EXPECT_FALSE(journal_->counts().failing);
  Open();
  EXPECT_EQ(Told(*journal_, key), "1:x 2:z ");
}

TEST_F(SqliteJournalTest, AtTheEndASyncThatHangsIsWaitedForAndTheRestIsRefused) {
  OpenFailing();
  const auto a = *journal_->Create("a", ""), b = *journal_->Create("b", "");
  EXPECT_EQ(journal_->counts().oldest_write, absl::ZeroDuration());
  FailingVfs::HoldSyncs();
  absl::Status first, second, third;
  std::thread one([&] { first = journal_->Append(a, Entry{1, "x"}, std::nullopt); });
  test::WaitUntil("the sync", [] { return FailingVfs::held() == 1; });
  std::thread two([&] { second = journal_->Append(b, Entry{1, "y"}, std::nullopt); });
  std::thread three([&] { third = journal_->Create("c", "").status(); });
  test::WaitUntil("an old write",
                  [this] { return journal_->counts().oldest_write > absl::Milliseconds(50); });
  EXPECT_EQ(Told(*journal_, a), "");  // reading goes on
  EXPECT_FALSE(journal_->counts().failing);
  journal_->EndWrites(absl::UnavailableError("it ends"));
  two.join();
  three.join();
  EXPECT_EQ(second.message(), "it ends");
  EXPECT_EQ(third.message(), "it ends");
  EXPECT_EQ(journal_->Append(b, Entry{1, "y"}, std::nullopt).message(), "it ends");
  EXPECT_EQ(journal_->Delete(b).message(), "it ends");
  EXPECT_EQ(FailingVfs::held(), 1);
  FailingVfs::Heal();
  one.join();
  EXPECT_TRUE(first.ok()) << first;
  EXPECT_EQ(journal_->counts().oldest_write, absl::ZeroDuration());
  Open();
  EXPECT_EQ(Told(*journal_, a), "1:x ");
  EXPECT_EQ(Told(*journal_, b), "");
  EXPECT_EQ(journal_->List()->size(), 2u);
}

// A short script of a journal. Every step is repeated until it succeeds, `healed` times at most.
// `model` has what is acknowledged; the journal must have the same, at once and when the files are
// opened as a crash would leave them.
class FailureAtEveryWrite : public SqliteJournalTest,
                            public ::testing::WithParamInterface<std::tuple<bool, int>> {
 protected:
  void Step(const std::function<absl::Status()>& step, const std::function<void()>& acknowledged) {
    const absl::Status status = step();
    if (status.ok()) {
      acknowledged();
    } else {
      EXPECT_TRUE(absl::IsUnavailable(status)) << status;
      // After a crash a failed step may be complete; not before.
      ExpectModel(*journal_);
      FailingVfs::Heal();
      const absl::Status again = step();
      EXPECT_TRUE(again.ok()) << again;
      if (again.ok()) acknowledged();
    }
    ExpectModel(*journal_);
    ExpectModelAfterCrash();
  }

  void ExpectModel(Journal& journal) {
    const auto meshes = journal.List();
    ASSERT_TRUE(meshes.ok()) << meshes.status();
    ASSERT_EQ(meshes->size(), model_.size());
    for (const Journal::Mesh& mesh : *meshes) EXPECT_EQ(Told(journal, mesh.key), model_[mesh.id]);
  }

  // What is in the files now, opened elsewhere.
  void ExpectModelAfterCrash() {
    test::TempFolder copy;
    CopyJournal(folder_.path(), copy.path());
    const auto journal = SqliteJournal::Open(copy.path(), {});
    ASSERT_TRUE(journal.ok()) << journal.status();
    ExpectModel(**journal);
  }

  void Script() {
    Journal::Key a = 0, b = 0;
    const auto create = [&](const char* id, Journal::Key* key) {
      Step(
          [&] {
            const auto made = journal_->Create(id, "d");
            if (made.ok()) *key = *made;
            return made.status();
          },
          [&] { model_[id] = ""; });
    };
    const auto append = [&](Journal::Key key, const char* id, std::uint64_t r,
                            const std::string& data) {
      Step(
          [&] {
            return journal_->Append(key, Entry{r, data}, std::nullopt);
          },
          [&] { absl::StrAppend(&model_[id], r, ":", data, " "); });
    };
    create("a", &a);
    append(a, "a", 1, "x");
    append(a, "a", 2, std::string(9'000, 'y'));
    create("b", &b);
    append(b, "b", 1, "z");
    Step([&] { return journal_->Compact(a, 2, {"s"}); }, [&] { model_["a"] = "@2:s "; });
    append(a, "a", 3, "w");
    Step([&] { return journal_->Delete(b); }, [&] { model_.erase("b"); });
    append(a, "a", 4, "v");
  }

  std::map<std::string, std::string> model_;
};

TEST_P(FailureAtEveryWrite, LosesNothingThatWasAcknowledged) {
  const auto [ever, error] = GetParam();
  int at = 1;
  for (;; ++at) {
    SCOPED_TRACE(absl::StrCat("operation ", at));
    std::filesystem::remove_all(folder_.path());
    model_.clear();
    OpenFailing();
    FailingVfs::FailAt(at, ever, error);
    Script();
    if (HasFailure() || FailingVfs::failures() == 0) break;
    FailingVfs::Heal();
    Open();
    ExpectModel(*journal_);
  }
  EXPECT_GT(at, 20);
}

INSTANTIATE_TEST_SUITE_P(Disks, FailureAtEveryWrite,
                         ::testing::Combine(::testing::Bool(),
                                            ::testing::Values(SQLITE_FULL, SQLITE_IOERR_WRITE)));

}  // namespace
}  // namespace dynmesh::server
