// A journal with a log that was damaged or cut anywhere, or torn by a loss of power: no
// acknowledged change is lost silently, and no false loss is reported.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "tests/server/journal/damage_fixture.h"
#include "tests/support/nightly.h"
#include "tests/support/seed.h"

namespace dynmesh::server {
namespace {

using Entry = Journal::Entry;

// ------------------------------------------------------------------ every byte of the log

// An eighth of the places each, so that they run side by side. At night all of them, by day one of
// kStride, another one in each run.
constexpr std::size_t kParts = 8, kStride = 5;
class EveryByteOfTheLog : public DamageTest, public ::testing::WithParamInterface<int> {
 protected:
  void SetUp() override {
    OpenFresh();
    Fill();
    files_ = Snap();
    journal_.reset();
    ASSERT_GT(files_[kLog].size(), 10'000u);
    ASSERT_LT(files_[kLog].size(), 100'000u);
    seed_ = test::NewSeed();
    step_ = kParts;
    first_ = static_cast<std::size_t>(GetParam());
    if (!test::IsNightly()) {
      step_ *= kStride;
      first_ += kParts * (seed_ % kStride);
    }
  }
  Files files_;
  std::uint64_t seed_ = 0;
  std::size_t first_ = 0, step_ = 0;
};

TEST_P(EveryByteOfTheLog, FlippedIsRepairedOrNamed) {
  SCOPED_TRACE(absl::StrCat("seed ", seed_));
  std::size_t named = 0, whole = 0;
  const std::size_t size = files_[kLog].size();
  for (std::size_t at = first_; at < size; at += step_) {
    Files damaged = files_;
    damaged[kLog][at] = static_cast<char>(damaged[kLog][at] ^ (1 << (at / step_ % 8)));
    WriteFiles(damaged, folder_.path());
    ASSERT_TRUE(Open().ok()) << "byte " << at;
    const bool some = !Named().empty();
    ++(some ? named : whole);
    ASSERT_FALSE(HasFailure()) << "byte " << at;
  }
  EXPECT_GT(named, size / step_ / 3);
}

TEST_P(EveryByteOfTheLog, CutThereIsRepairedOrNamed) {
  SCOPED_TRACE(absl::StrCat("seed ", seed_));
  std::size_t named = 0;
  const std::size_t size = files_[kLog].size();
  for (std::size_t at = first_; at < size; at += step_) {
    Files damaged = files_;
    damaged[kLog].resize(at);
    WriteFiles(damaged, folder_.path());
    ASSERT_TRUE(Open().ok()) << "length " << at;
    if (!Named().empty()) ++named;
    ASSERT_FALSE(HasFailure()) << "length " << at;
  }
  EXPECT_GT(named, size / step_ / 3);
}

TEST_P(EveryByteOfTheLog, FlippedAfterALossOfPowerIsStillNamed) {
  // The record is as old as it can be: only the meshes' names are in it.
  const std::string early = [&] {
    QuickFolder other;
    auto heads = *HeadsFile::Make(other.path(), (*HeadsFile::Open(folder_.path()))->journal(), {},
                                  HeadsFile::Taking::kNo);
    for (const auto& [id, known] : truth_) {
      EXPECT_TRUE(heads->Put({known.key, id, 0, 0, 0, HeadsFile::State::kThere}).ok());
    }
    EXPECT_TRUE(heads->Sync().ok());
    heads.reset();
    return ReadFile(other.path() + "/" + HeadsFile::kFileName);
  }();
  Files old = files_;
  old[HeadsFile::kFileName] = early;
  // The last transaction is not known to have been acknowledged.
  WriteFiles(old, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names());
  Truth all = truth_;
  const std::size_t size = files_[kLog].size();
  std::size_t silent = 0;
  for (std::size_t at = static_cast<std::size_t>(GetParam()) * 7; at < size; at += kParts * 7) {
    Files damaged = old;
    damaged[kLog][at] = static_cast<char>(damaged[kLog][at] ^ (1 << (at % 8)));
    WriteFiles(damaged, folder_.path());
    ASSERT_TRUE(Open().ok()) << "byte " << at;
    const auto meshes = *journal_->List();
    for (const Journal::Mesh& mesh : meshes) {
      if (!mesh.loss.ok() || !mesh.damage.ok() || mesh.id == "c") continue;
      EXPECT_EQ(Told(*journal_, mesh.key), truth_[mesh.id].told) << "byte " << at;
    }
    if (LossOf("c").ok() && Told(*journal_, truth_["c"].key) != truth_["c"].told) ++silent;
    ASSERT_FALSE(HasFailure()) << "byte " << at;
  }
  // A loss of only the last transaction cannot be detected.
  EXPECT_LT(silent * 3, size / kParts / 7);
}

INSTANTIATE_TEST_SUITE_P(Parts, EveryByteOfTheLog, ::testing::Range(0, static_cast<int>(kParts)));

// ------------------------------------------------------------------ no false alarms

// The power failed during the last transaction, with any state that a disk may leave, and a record
// of any age: no acknowledged change is lost, and no loss is reported.
TEST_F(DamageTest, ATornTransactionIsNoDamage) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("seed ", seed));
  std::mt19937 random(seed);
  OpenFresh();
  Fill();
  std::vector<std::string> records = {Snap()[HeadsFile::kFileName]};
  for (std::uint64_t r = 3; r <= 6; ++r) {
    Append("a", r, absl::StrCat("q", r));
    records.push_back(Snap()[HeadsFile::kFileName]);
  }
  const Files before = Snap();
  const std::string told = truth_["a"].told;
  ASSERT_TRUE(
      journal_->Append(truth_["a"].key, Entry{7, std::string(3'000, 'x')}, std::nullopt).ok());
  const std::string after = Told(*journal_, truth_["a"].key);
  const std::string log = Snap()[kLog];
  journal_.reset();
  constexpr std::size_t kSector = 512;
  int gone = 0, there = 0;
  for (int trial = 0; trial < 1'000; ++trial) {
    Files files = before;
    std::string& torn = files[kLog];
    // Sectors that the disk had, any of them.
    const double share = std::uniform_real_distribution<>(0, 1.2)(random);
    for (std::size_t at = 0; at < log.size(); at += kSector) {
      if (std::uniform_real_distribution<>(0, 1)(random) > share) continue;
      const std::size_t count = std::min(kSector, log.size() - at);
      if (torn.size() < at + count) torn.resize(at + count);
      torn.replace(at, count, log, at, count);
    }
    std::string& record = files[HeadsFile::kFileName];
    const std::string& old = records[random() % records.size()];
    for (std::size_t at = 0; at + kSector <= old.size(); at += kSector) {
      if (random() % 2 == 0) record.replace(at, kSector, old, at, kSector);
    }
    WriteFiles(files, folder_.path());
    ASSERT_TRUE(Open().ok());
    for (const char* id : {"a", "b", "c"}) {
      ASSERT_TRUE(LossOf(id).ok()) << LossOf(id) << " trial " << trial;
    }
    const std::string now = Told(*journal_, truth_["a"].key);
    ASSERT_TRUE(now == told || now == after) << now;
    ++(now == told ? gone : there);
  }
  EXPECT_GT(gone, 100);
  EXPECT_GT(there, 50);
}

TEST_F(DamageTest, AnEndInTheMiddleOfADeletionIsNoLoss) {
  OpenFresh();
  Fill();
  const Files before = Snap();
  Files marked = before;
  {
    WriteFiles(before, folder_.path());
    journal_.reset();
    WriteFiles(before, folder_.path());
    auto heads = *HeadsFile::Open(folder_.path());
    ASSERT_TRUE(heads->BeginDelete(truth_["b"].key).ok());
    heads.reset();
    marked[HeadsFile::kFileName] = Snap()[HeadsFile::kFileName];
  }
  WriteFiles(marked, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names());  // it was not deleted
  ASSERT_TRUE(journal_->Delete(truth_["b"].key).ok());
  Files deleted = Snap();
  deleted[HeadsFile::kFileName] = marked[HeadsFile::kFileName];
  WriteFiles(deleted, folder_.path());
  truth_.erase("b");
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names());
  EXPECT_EQ(journal_->List()->size(), 2u);
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names());
}

TEST_F(DamageTest, ADeletionThatIsUndoneIsNamed) {
  OpenFresh();
  Fill();
  ASSERT_TRUE(Open().ok());
  Files files = Snap();
  ASSERT_TRUE(journal_->Delete(truth_["b"].key).ok());
  files[HeadsFile::kFileName] = Snap()[HeadsFile::kFileName];
  WriteFiles(files, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names({"b"}));
}

// Damage of the record alone; the journal is complete.
TEST_F(DamageTest, ADamagedRecordLosesNothing) {
  OpenFresh();
  Fill();
  const Files files = Snap();
  journal_.reset();
  const std::string& record = files.at(HeadsFile::kFileName);
  int trials = 0;
  for (std::size_t at = 0; at < record.size(); ++at) {
    if (record[at] == 0 && at % 16 != 0) continue;
    Files damaged = files;
    damaged[HeadsFile::kFileName][at] = static_cast<char>(record[at] ^ (1 << (at % 8)));
    WriteFiles(damaged, folder_.path());
    ASSERT_TRUE(Open().ok()) << "byte " << at;
    EXPECT_EQ(Named(), Names()) << "byte " << at;
    ASSERT_FALSE(HasFailure());
    ++trials;
  }
  EXPECT_GT(trials, 400);
  // If it was cut, its content may be unknown; the rest can be read.
  for (std::size_t size = 0; size < record.size(); size += 128) {
    Files damaged = files;
    damaged[HeadsFile::kFileName].resize(size);
    WriteFiles(damaged, folder_.path());
    ASSERT_TRUE(Open().ok()) << "length " << size;
    for (const auto& [id, known] : truth_) EXPECT_EQ(Told(*journal_, known.key), known.told);
  }
  Files none = files;
  none.erase(HeadsFile::kFileName);
  WriteFiles(none, folder_.path());
  ASSERT_TRUE(Open().ok());
  EXPECT_EQ(Named(), Names({"a", "b", "c"}));
}

TEST_F(DamageTest, ManyMeshesComeAndGo) {
  OpenFresh();
  std::map<Journal::Key, std::uint64_t> there;
  for (int i = 0; i < 200; ++i) {
    const auto key = *journal_->Create(absl::StrCat("m", i), "");
    there[key] = 0;
    for (auto& [mesh, revision] : there) {
      if ((mesh + i) % 37 != 0) continue;
      ASSERT_TRUE(journal_->Append(mesh, Entry{++revision, "e"}, std::nullopt).ok());
    }
    if (i % 3 == 2) {
      const auto victim = std::next(there.begin(), static_cast<long>(there.size() / 2));
      ASSERT_TRUE(journal_->Delete(victim->first).ok());
      there.erase(victim);
    }
  }
  Files files = Snap();
  journal_.reset();
  {
    const auto heads = *HeadsFile::Open(folder_.path());
    ASSERT_EQ(heads->Heads().size(), there.size());
    for (const HeadsFile::Head& head : heads->Heads()) {
      EXPECT_EQ(head.revision, there.at(head.key));
    }
    EXPECT_EQ(heads->unreadable(), 0u);
  }
  WriteFiles(files, folder_.path());
  ASSERT_TRUE(Open().ok());
  const auto meshes = *journal_->List();
  for (const Journal::Mesh& mesh : meshes) EXPECT_TRUE(mesh.loss.ok()) << mesh.loss;
  EXPECT_EQ(meshes.size(), there.size());
}

}  // namespace
}  // namespace dynmesh::server
