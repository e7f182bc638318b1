// The data folder goes away under an open journal: nothing is acknowledged into it until it is
// back.
#include "server/journal/journal_presence.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"
#include "server/journal/sqlite.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/failing_vfs.h"
#include "tests/server/journal/told.h"
#include "tests/support/deadline.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server {
namespace {

namespace fs = std::filesystem;
using Entry = Journal::Entry;

class JournalPresenceTest : public ::testing::Test {
 protected:
  JournalPresenceTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }
  ~JournalPresenceTest() override { FailingVfs::Heal(); }

  void Open(const char* vfs = nullptr) {
    journal_.reset();
    SqliteJournal::Options options;
    options.vfs = vfs;
    auto opened = SqliteJournal::Open(data_, options);
    ASSERT_TRUE(opened.ok()) << opened.status();
    journal_ = *std::move(opened);
  }
  void OpenWithMesh() {
    Open();
    key_ = *journal_->Create("m", "");
    ASSERT_TRUE(Append(1).ok());
  }
  absl::Status Append(std::uint64_t revision) {
    return journal_->Append(key_, Entry{revision, "e"}, Journal::Request{"r", "a"});
  }
  void ExpectGone() {
    for (int i = 0; i < 2; ++i) {
      const absl::Status refused = Append(2);
      EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
      EXPECT_TRUE(absl::StrContains(refused.message(), data_ + "/journal.")) << refused;
      EXPECT_TRUE(absl::StrContains(refused.message(), "Put the data folder back")) << refused;
    }
    EXPECT_TRUE(absl::IsUnavailable(journal_->Create("n", "").status()));
    EXPECT_TRUE(absl::IsUnavailable(journal_->Delete(key_)));
    EXPECT_TRUE(absl::IsUnavailable(journal_->Compact(key_, 1, {"p"})));
    EXPECT_TRUE(absl::StartsWith(Told(*journal_, key_), "UNAVAILABLE"));
    EXPECT_TRUE(absl::IsUnavailable(journal_->List().status()));
    EXPECT_TRUE(journal_->counts().gone);
    EXPECT_TRUE(journal_->counts().failing);
  }
  void ExpectThatItGoesOn() {
    EXPECT_TRUE(Append(2).ok());
    EXPECT_FALSE(journal_->counts().gone);
    EXPECT_FALSE(journal_->counts().failing);
    EXPECT_TRUE(Append(3).ok());
    const std::string all = "?r=a ?r=a ?r=a 1:e 2:e 3:e ";
    EXPECT_EQ(Told(*journal_, key_), all);
    Open();
    EXPECT_EQ(Told(*journal_, key_), all);
    EXPECT_EQ(journal_->List()->size(), 1u);
    EXPECT_TRUE(journal_->List()->front().loss.ok());
  }

  test::TempFolder folder_;
  const std::string data_ = folder_.path() + "/data", moved_ = folder_.path() + "/moved";
  std::unique_ptr<SqliteJournal> journal_;
  Journal::Key key_ = 0;
};

TEST_F(JournalPresenceTest, AFolderThatIsRenamedSealsTheJournalUntilItIsBack) {
  OpenWithMesh();
  fs::rename(data_, moved_);
  ExpectGone();
  EXPECT_FALSE(fs::exists(data_));
  fs::rename(moved_, data_);
  ExpectThatItGoesOn();
}

TEST_F(JournalPresenceTest, AnEmptyFolderInItsPlaceStaysEmpty) {
  OpenWithMesh();
  fs::rename(data_, moved_);
  fs::create_directory(data_);
  ExpectGone();
  EXPECT_TRUE(fs::is_empty(data_));
  fs::remove(data_);
  fs::rename(moved_, data_);
  ExpectThatItGoesOn();
}

// It is neither read nor written, nor does it lose its log when this journal is closed.
TEST_F(JournalPresenceTest, AnotherJournalInItsPlaceIsLeftAlone) {
  const std::string another = folder_.path() + "/another";
  {
    auto other = *SqliteJournal::Open(another, {});
    const Journal::Key key = *other->Create("other", "");
    ASSERT_TRUE(other->Append(key, Entry{1, "theirs"}, std::nullopt).ok());
    fs::create_directory(folder_.path() + "/copy");
    for (const char* file : {"/journal.sqlite", "/journal.sqlite-wal", "/journal.heads"}) {
      fs::copy(another + file, folder_.path() + "/copy" + file);
    }
  }
  OpenWithMesh();
  fs::rename(data_, moved_);
  fs::rename(folder_.path() + "/copy", data_);
  const auto size = fs::file_size(data_ + "/journal.sqlite-wal");
  ExpectGone();
  journal_.reset();
  EXPECT_EQ(fs::file_size(data_ + "/journal.sqlite-wal"), size);
  Open();
  EXPECT_EQ(journal_->List()->front().id, "other");
  EXPECT_EQ(Told(*journal_, journal_->List()->front().key), "1:theirs ");
  journal_.reset();
  fs::remove_all(data_);
  fs::rename(moved_, data_);
  Open();
  EXPECT_EQ(Told(*journal_, key_), "?r=a 1:e ");
}

// Every file counts: what is lost of one is found by none of the others.
TEST_F(JournalPresenceTest, AFileThatIsRemovedOrExchangedSealsTheJournal) {
  for (const char* file : {"/journal.sqlite", "/journal.sqlite-wal", "/journal.heads"}) {
    SCOPED_TRACE(file);
    fs::remove_all(data_);
    OpenWithMesh();
    fs::rename(data_ + file, moved_);
    ExpectGone();
    fs::copy(moved_, data_ + file);  // the same bytes, but nothing more is written there
    ExpectGone();
    fs::rename(moved_, data_ + file);
    ExpectThatItGoesOn();
    journal_.reset();
  }
}

// Without an edit, too: each change is told once.
TEST_F(JournalPresenceTest, ItIsNoticedWithinASecondAndToldOnce) {
  OpenWithMesh();
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  fs::rename(data_, moved_);
  test::WaitUntil("the journal to be gone", [this] { return journal_->counts().gone; });
  EXPECT_FALSE(Append(2).ok());
  EXPECT_FALSE(Append(2).ok());
  fs::rename(moved_, data_);
  test::WaitUntil("the journal to be back", [this] { return !journal_->counts().gone; });
  EXPECT_FALSE(journal_->counts().failing);
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("off").ok());
  const auto count = [&log](const std::string& event) {
    int times = 0;
    for (std::size_t at = 0; (at = log.find(event, at)) != std::string::npos; ++at) ++times;
    return times;
  };
  EXPECT_EQ(count("level=error event=journal_gone"), 1) << log;
  EXPECT_EQ(count("event=journal_back"), 1) << log;
  EXPECT_EQ(count("journal_failed"), 0) << log;
  ExpectThatItGoesOn();
}

// What is acknowledged is there, in order and once, whatever the moments.
TEST_F(JournalPresenceTest, WritersThatGoOnMeanwhileLoseNothing) {
  Open();
  constexpr int kWriters = 3, kRounds = 25;
  std::atomic<bool> end{false};
  std::atomic<int> refused{0}, acknowledged{0};
  std::vector<std::uint64_t> last(kWriters, 0);
  std::vector<Journal::Key> keys;
  for (int w = 0; w < kWriters; ++w) keys.push_back(*journal_->Create(absl::StrCat("m", w), ""));
  std::vector<std::thread> writers;
  for (std::size_t w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      while (!end) {
        const absl::Status status =
            journal_->Append(keys[w], Entry{last[w] + 1, absl::StrCat(last[w] + 1)}, std::nullopt);
        EXPECT_TRUE(status.ok() || absl::IsUnavailable(status)) << status;
        ++(status.ok() ? acknowledged : refused);
        if (status.ok()) ++last[w];
      }
    });
  }
  for (int round = 0; round < kRounds; ++round) {
    const int acknowledged_before = acknowledged, refused_before = refused;
    test::WaitUntil("appends", [&] { return acknowledged > acknowledged_before + 5; });
    fs::rename(data_, moved_);
    test::WaitUntil("refusals", [&] { return refused > refused_before + 2 * kWriters; });
    // Each writer was refused since, so nothing more is written.
    const int now = acknowledged;
    test::WaitUntil("more refusals", [&] { return refused > refused_before + 20 * kWriters; });
    EXPECT_LE(acknowledged, now + kWriters);
    fs::rename(moved_, data_);
  }
  end = true;
  for (std::thread& writer : writers) writer.join();
  Open();
  for (std::size_t w = 0; w < kWriters; ++w) {
    std::string wanted;
    for (std::uint64_t r = 1; r <= last[w]; ++r) absl::StrAppend(&wanted, r, ":", r, " ");
    EXPECT_EQ(Told(*journal_, keys[w]), wanted);
  }
}

// A disk that failed before is still probed first.
TEST_F(JournalPresenceTest, AJournalThatFailedBeforeIsProbedWhenTheFolderIsBack) {
  Open(FailingVfs::Name());
  key_ = *journal_->Create("m", "");
  ASSERT_TRUE(Append(1).ok());
  FailingVfs::FailAt(1, /*ever=*/true);
  EXPECT_FALSE(Append(2).ok());
  fs::rename(data_, moved_);
  EXPECT_FALSE(Append(2).ok());
  fs::rename(moved_, data_);
  EXPECT_FALSE(Append(2).ok());
  EXPECT_TRUE(journal_->counts().failing);
  EXPECT_FALSE(journal_->counts().gone);
  FailingVfs::Heal();
  ExpectThatItGoesOn();
}

TEST_F(JournalPresenceTest, AFolderWithoutItsLockFileIsStillLocked) {
  OpenWithMesh();
  fs::remove(data_ + "/lock");
  const absl::Status second = SqliteJournal::Open(data_, {}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(second)) << second;
  EXPECT_TRUE(absl::StrContains(second.message(), "in use by another process")) << second;
  EXPECT_TRUE(absl::StrContains(second.message(), "`lock` was removed")) << second;
  EXPECT_FALSE(fs::exists(data_ + "/lock"));
  EXPECT_TRUE(Append(2).ok());
  journal_.reset();
  Open();
  EXPECT_TRUE(Append(3).ok());
}

// As where a file system knows no locks of folders.
TEST_F(JournalPresenceTest, RowsOfAnotherProcessAreSaidToBeThat) {
  OpenWithMesh();
  {
    auto another = *sqlite::Connection::Open(data_ + "/journal.sqlite", nullptr);
    ASSERT_TRUE(another.Run("UPDATE meshes SET head = 7").ok());
  }
  ASSERT_TRUE(SetLogLevel("error").ok());
  testing::internal::CaptureStderr();
  for (int i = 0; i < 2; ++i) {
    const absl::Status refused = Append(2);
    EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
    const absl::Status told = JournalError(refused, "m");
    EXPECT_EQ(told.code(), absl::StatusCode::kDataLoss);
    EXPECT_TRUE(absl::StrContains(told.message(), "another process writes to this journal"));
    EXPECT_TRUE(absl::StrContains(told.message(), "end any other process")) << told;
    EXPECT_FALSE(absl::StrContains(told.message(), "restore")) << told;
  }
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(log.find("event=journal_shared"), log.rfind("event=journal_shared")) << log;
  EXPECT_NE(log.find("event=journal_shared"), std::string::npos) << log;
}

}  // namespace
}  // namespace dynmesh::server
