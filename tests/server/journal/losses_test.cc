// Files that are incomplete, mixed up, or not what they seem: reported losses, refusals, and how an
// operator continues.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "tests/server/journal/damage_fixture.h"

namespace dynmesh::server {
namespace {

namespace fs = std::filesystem;
using Entry = Journal::Entry;

// ------------------------------------------------------------------ the operator's view

TEST_F(DamageTest, ALostTailNamesTheMeshesAndStaysReadOnlyUntilItIsAccepted) {
  OpenFresh();
  Fill();
  Files files = Snap();
  Append("a", 3);
  Append("b", 2);
  files[HeadsFile::kFileName] = Snap()[HeadsFile::kFileName];
  Files damaged = files;
  WriteFiles(damaged, folder_.path());
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(Open({"a@1", "b@none", "c@1", "12345678"}).ok());  // other losses
    const absl::Status a = LossOf("a");
    EXPECT_TRUE(absl::StrContains(a.message(), "revision 3 was acknowledged")) << a;
    EXPECT_TRUE(absl::StrContains(a.message(), "has revision 2")) << a;
    EXPECT_TRUE(absl::StrContains(a.message(), "--accept-loss=a@2")) << a;
    EXPECT_TRUE(absl::StrContains(LossOf("b").message(), "--accept-loss=b@1"));
    EXPECT_TRUE(LossOf("c").ok());
    EXPECT_EQ(Told(*journal_, truth_["a"].key), "?r1=A 1:a-1 2:a-2 ");
    EXPECT_TRUE(
        absl::IsDataLoss(journal_->Append(truth_["a"].key, Entry{3, "again"}, std::nullopt)));
    EXPECT_TRUE(absl::IsDataLoss(journal_->Compact(truth_["a"].key, 2, {"s"})));
    Append("c", 2u + static_cast<unsigned>(i));
  }
  ASSERT_TRUE(Open({"a@2"}).ok());
  EXPECT_TRUE(LossOf("a").ok());
  EXPECT_FALSE(LossOf("b").ok());
  Append("a", 3);
  ASSERT_TRUE(journal_->Delete(truth_["b"].key).ok());
  truth_.erase("b");
  // It was accepted once, and needs no more.
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names());
  EXPECT_EQ(Told(*journal_, truth_["a"].key), "?r1=A 1:a-1 2:a-2 3:a-3 ");
}

TEST_F(DamageTest, ALogThatIsGoneIsToldOfEachMesh) {
  OpenFresh();
  Fill();
  Files files = Snap();
  files.erase(kLog);
  WriteFiles(files, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names({"a", "b", "c"}));
  EXPECT_TRUE(absl::StrContains(LossOf("a").message(), "nothing of the mesh")) << LossOf("a");
  EXPECT_TRUE(absl::StrContains(LossOf("a").message(), "--accept-loss=a@none")) << LossOf("a");
  // New meshes do not reuse the old ones' keys.
  const auto fresh = journal_->Create("d", "");
  ASSERT_TRUE(fresh.ok());
  EXPECT_GT(*fresh, truth_["c"].key);
  ASSERT_TRUE(journal_->Delete(truth_["b"].key).ok());
  truth_.erase("b");
  ASSERT_TRUE(Open({"a@none"}).ok());
  truth_.erase("a");
  EXPECT_EQ(Named(), Names({"c"}));
  EXPECT_EQ(journal_->List()->size(), 2u);
}

TEST_F(DamageTest, ADatabaseThatIsGoneIsToldOfEachMesh) {
  for (const bool with_log : {false, true}) {
    for (const char* left : {"", static_cast<const char*>(nullptr)}) {
      WriteFiles({}, folder_.path());
      truth_.clear();
      OpenFresh();
      Fill();
      Files files = Snap();
      if (!with_log) files.erase(kLog);
      if (left == nullptr) {
        files.erase(kDatabase);
      } else {
        files[kDatabase] = left;
      }
      const std::string log = files[kLog];
      WriteFiles(files, folder_.path());
      ASSERT_TRUE(Open().ok());
      EXPECT_EQ(Named(), Names({"a", "b", "c"}));
      // For experts.
      if (with_log) {
        EXPECT_EQ(ReadFile(folder_.path() + "/journal.lost.wal"), log);
      }
    }
  }
}

TEST_F(DamageTest, ACopyOfTheDatabaseAloneIsNoBackup) {
  OpenFresh();
  Fill();
  ASSERT_TRUE(Open().ok());  // moves the log into the database
  Append("a", 3);
  const Files files = {{kDatabase, Snap()[kDatabase]}};
  std::string code;
  for (int i = 0; i < 2; ++i) {
    if (i == 0) WriteFiles(files, folder_.path());
    ASSERT_TRUE(Open().ok());
    EXPECT_EQ(Named(), Names({"a", "b", "c"})) << i;
    EXPECT_TRUE(absl::StrContains(LossOf("a").message(), "is not known")) << LossOf("a");
    EXPECT_EQ(Told(*journal_, truth_["a"].key), "?r1=A 1:a-1 2:a-2 ");
  }
  ASSERT_TRUE(Open({"a@2", "b@1", "c@1"}).ok());
  for (const char* id : {"a", "b", "c"}) Remember(id);
  EXPECT_EQ(Named(), Names());
}

TEST_F(DamageTest, TheCodeAcceptsAllLossesAndNoOthers) {
  OpenFresh();
  Fill();
  Files files = Snap();
  files.erase(kLog);
  WriteFiles(files, folder_.path());
  ASSERT_TRUE(SetLogLevel("error").ok());
  testing::internal::CaptureStderr();
  ASSERT_TRUE(Open().ok());
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(SetLogLevel("off").ok());
  EXPECT_TRUE(absl::StrContains(log, "event=mesh_loss mesh=a key=1 acknowledged=2 found=none"))
      << log;
  const std::string flag = "accept_all=\"--accept-loss=";
  const std::size_t at = log.find(flag);
  ASSERT_NE(at, std::string::npos) << log;
  const std::string code = log.substr(at + flag.size(), 8);
  ASSERT_TRUE(Open({code}).ok());
  EXPECT_TRUE(journal_->List()->empty());
  truth_.clear();
  Create("e");
  Append("e", 1);
  Files later = Snap();
  later.erase(kLog);
  WriteFiles(later, folder_.path());
  ASSERT_TRUE(Open({code}).ok());
  EXPECT_EQ(Named(), Names({"e"}));
}

TEST_F(DamageTest, ABackupInAnEmptyFolderIsTakenOver) {
  OpenFresh();
  Fill();
  QuickFolder backup;
  {
    auto db = *sqlite::Connection::Open(folder_.path() + "/" + kDatabase, nullptr);
    ASSERT_TRUE(db.Run(absl::StrCat("VACUUM INTO '", backup.path(), "/b'").c_str()).ok());
  }
  const std::string bytes = ReadFile(backup.path() + "/b");
  journal_.reset();
  WriteFiles({{kDatabase, bytes}}, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names());
  Append("a", 3);
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names());
}

TEST_F(DamageTest, ABackupOverAFolderInUseIsNamedMeshByMesh) {
  OpenFresh();
  Fill();
  QuickFolder backup;
  {
    auto db = *sqlite::Connection::Open(folder_.path() + "/" + kDatabase, nullptr);
    ASSERT_TRUE(db.Run(absl::StrCat("VACUUM INTO '", backup.path(), "/b'").c_str()).ok());
  }
  Append("a", 3);
  Append("c", 2);
  ASSERT_TRUE(journal_->Delete(truth_["b"].key).ok());
  Files files = Snap();
  journal_.reset();
  files[kDatabase] = ReadFile(backup.path() + "/b");
  // The log of the later database would be applied to the backup.
  WriteFiles(files, folder_.path());
  const absl::Status refused = Open();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_TRUE(absl::StrContains(refused.message(), "a log that is not its own")) << refused;
  EXPECT_EQ(Snap(), files);
  files.erase(kLog);
  WriteFiles(files, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_TRUE(absl::StrContains(LossOf("a").message(), "--accept-loss=a@2")) << LossOf("a");
  EXPECT_TRUE(absl::StrContains(LossOf("c").message(), "--accept-loss=c@1")) << LossOf("c");
  // It was deleted, and is back: perhaps the backup was restored for it.
  EXPECT_TRUE(absl::StrContains(LossOf("b").message(), "--accept-loss=b@1")) << LossOf("b");
  ASSERT_TRUE(Open({"a@2", "b@1", "c@1"}).ok());
  for (const char* id : {"a", "b", "c"}) EXPECT_TRUE(LossOf(id).ok()) << id;
}

TEST_F(DamageTest, FilesOfTwoFoldersAreNotMixed) {
  OpenFresh();
  Fill();
  const Files first = Snap();
  journal_.reset();
  WriteFiles({}, folder_.path());
  OpenFresh();
  for (const char* id : {"x", "y"}) ASSERT_TRUE(journal_->Create(id, "").ok());
  Files mixed = Snap();
  journal_.reset();
  mixed[HeadsFile::kFileName] = first.at(HeadsFile::kFileName);
  WriteFiles(mixed, folder_.path());
  const absl::Status refused = Open();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_TRUE(absl::StrContains(refused.message(), "another journal")) << refused;
  EXPECT_EQ(Snap(), mixed);
  const std::string text(refused.message());
  ASSERT_TRUE(Open({text.substr(text.size() - 8)}).ok());
  EXPECT_TRUE(LossOf("x").ok() && LossOf("y").ok());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(journal_->List()->size(), 2u);
}

TEST_F(DamageTest, OtherContentUnderTheSameRevisionIsNamed) {
  OpenFresh();
  Fill();
  const Files fork = Snap();
  Append("a", 3);
  const std::string heads = Snap()[HeadsFile::kFileName];
  WriteFiles(fork, folder_.path());
  ASSERT_TRUE(Open().ok());
  for (const std::uint64_t r : {3u, 4u}) {
    ASSERT_TRUE(journal_->Append(truth_["a"].key, Entry{r, "other"}, std::nullopt).ok());
  }
  Files mixed = Snap();
  mixed[HeadsFile::kFileName] = heads;
  WriteFiles(mixed, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_TRUE(absl::StrContains(LossOf("a").message(), "does not continue")) << LossOf("a");
  EXPECT_TRUE(LossOf("b").ok());
}

// ------------------------------------------------------------------ names

TEST_F(DamageTest, ANameThatCannotBeSaidIsTheRowsNumber) {
  OpenFresh();
  Fill();
  const Files files = Snap();
  // The record still has it.
  for (const bool record : {true, false}) {
    Files old = files;
    journal_.reset();
    WriteFiles(old, folder_.path());
    {
      auto db = *sqlite::Connection::Open(folder_.path() + "/" + kDatabase, nullptr);
      ASSERT_TRUE(db.Run("UPDATE meshes SET id = CAST(X'6DB3' AS TEXT) WHERE key = 1").ok());
    }
    if (!record) fs::remove(folder_.path() + "/" + HeadsFile::kFileName);
    ASSERT_TRUE(Open().ok());
    const std::string name = record ? "a" : "@1";
    const absl::Status damage = LossOf(name);
    EXPECT_TRUE(absl::IsDataLoss(damage)) << damage;
    EXPECT_TRUE(absl::StrContains(damage.message(), "m\\xb3")) << damage;
    ASSERT_TRUE(journal_->Delete(1).ok());
    EXPECT_TRUE(absl::IsNotFound(LossOf(name)));
  }
}

}  // namespace
}  // namespace dynmesh::server
