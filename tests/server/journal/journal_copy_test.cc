// Copies between folders: nothing is lost or added, whatever ends them.
#include "server/journal/journal_copy.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "server/base/log.h"
#include "server/journal/mesh_import.h"
#include "server/journal/whole_reading.h"
#include "tests/server/journal/copy_fixture.h"
#include "tests/server/journal/forwarding_journal.h"

namespace dynmesh::server {
namespace {

class JournalCopyTest : public ::testing::Test {
 protected:
  JournalCopyTest() {
    EXPECT_TRUE(SetLogLevel("off").ok());
    SqliteJournal::Options options;
    options.history_bytes = 12'000;
    from_ = OpenSqlite(from_folder_.path(), options);
    JournalFiller(*from_, 5).FillAll();
    to_ = OpenSqlite(to_folder_.path());
    options_.transaction_bytes = 500;
  }
  void ReopenTarget() {
    to_.reset();
    to_ = OpenSqlite(to_folder_.path());
  }
  std::int64_t TargetRows() {
    std::int64_t rows = 0;
    auto db = *sqlite::Connection::Open(to_folder_.path() + "/journal.sqlite", nullptr);
    for (const char* sql : {"SELECT count(*) FROM entries", "SELECT count(*) FROM snapshots",
                            "SELECT count(*) FROM generations", "SELECT count(*) FROM requests"}) {
      sqlite::Statement count(db, sql);
      EXPECT_TRUE(count.Step());
      rows += count.Integer(0);
    }
    return rows;
  }

  test::TempFolder from_folder_, to_folder_;
  std::unique_ptr<SqliteJournal> from_, to_;
  CopyOptions options_;
};

// A target whose writes fail from the n-th on, as if the program had ended there.
class EndingJournal final : public ForwardingJournal, public MeshImport {
 public:
  EndingJournal(SqliteJournal& journal, int writes)
      : ForwardingJournal(journal), journal_(journal), left_(writes) {}
  bool ended() const { return left_ < 0; }

  absl::StatusOr<Key> Create(const std::string&, const std::string&) override { return Gone(); }
  absl::Status Delete(Key) override { return Gone(); }
  bool Sweep(Key) override { return false; }
  using Journal::Append;
  absl::Status Append(Key, const std::vector<Entry>&, const std::vector<Request>&) override {
    return Gone();
  }
  absl::Status Read(Key mesh, const Visitor& visitor) override {
    return ended() ? Gone() : ForwardingJournal::Read(mesh, visitor);
  }
  absl::Status ReadPast(Key mesh, std::uint64_t from, std::uint64_t to,
                        const Visitor& visitor) override {
    return ended() ? Gone() : ForwardingJournal::ReadPast(mesh, from, to, visitor);
  }
  using Journal::Compact;
  absl::Status Compact(Key, std::uint64_t, const std::vector<std::string>&,
                       const std::atomic<bool>&) override {
    return Gone();
  }
  MeshImport* import() override { return this; }
  absl::StatusOr<Key> NewKey() override {
    if (--left_ < 0) return Gone();
    return journal_.NewKey();
  }
  absl::Status WriteUnseen(Key mesh, const std::vector<Part>& parts,
                           const std::vector<Entry>& entries) override {
    return --left_ < 0 ? Gone() : journal_.WriteUnseen(mesh, parts, entries);
  }
  absl::Status Publish(Key mesh, const Whole& whole) override {
    return --left_ < 0 ? Gone() : journal_.Publish(mesh, whole);
  }

 private:
  static absl::Status Gone() { return absl::UnavailableError("gone"); }

  SqliteJournal& journal_;
  int left_;
};

TEST_F(JournalCopyTest, GenerationsAreFoundThroughTheInterface) {
  for (const Journal::Mesh& mesh : MeshesOf(*from_)) {
    const auto generations = GenerationsOf(*from_, mesh.key);
    ASSERT_TRUE(generations.ok()) << generations.status();
    EXPECT_EQ(generations->front(), *from_->Oldest(mesh.key));
    if (mesh.id == "empty" || mesh.id == "entries") {
      EXPECT_EQ(generations->size(), 1u) << mesh.id;
    } else if (mesh.id == "generations") {
      EXPECT_GT(generations->size(), 2u);
      EXPECT_GT(generations->front(), 0u) << "a part was dropped";
    }
  }
}

TEST_F(JournalCopyTest, TheCopyIsTheSameToEachReader) {
  const std::vector<std::string> before = ToldAll(*from_);
  const auto counts = CopyMeshes(*from_, *to_, options_);
  ASSERT_TRUE(counts.ok()) << counts.status();
  EXPECT_EQ(counts->copied, 6u);
  EXPECT_EQ(counts->there, 0u);
  EXPECT_EQ(ToldAll(*to_), before);
  EXPECT_EQ(ToldAll(*from_), before) << "the source stays as it is";
  ReopenTarget();
  EXPECT_EQ(ToldAll(*to_), before);
  for (const Journal::Mesh& mesh : MeshesOf(*to_)) EXPECT_TRUE(mesh.loss.ok()) << mesh.loss;
  // It goes on as a journal.
  const auto meshes = MeshesOf(*to_);
  const Journal::Key last = meshes.back().key;
  JournalFiller filler(*to_, 6);
  EXPECT_GT(filler.Fill("new", 2, 5, 2), last);
  ReopenTarget();
  EXPECT_EQ(to_->List()->size(), 7u);
}

// The sizes of generations are those of the source: the same is dropped at the next snapshots.
TEST_F(JournalCopyTest, TheCopyDropsItsPastAsTheSourceDoes) {
  ASSERT_TRUE(CopyMeshes(*from_, *to_, options_).ok());
  to_.reset();
  SqliteJournal::Options options;
  options.history_bytes = 12'000;
  to_ = OpenSqlite(to_folder_.path(), options);
  const auto key_of = [](Journal& journal) {
    for (const Journal::Mesh& mesh : MeshesOf(journal)) {
      if (mesh.id == "generations") return mesh.key;
    }
    return Journal::Key{0};
  };
  const Journal::Key from_key = key_of(*from_), to_key = key_of(*to_);
  std::uint64_t head = 0;
  Journal::Visitor visitor;
  visitor.snapshot = [&](std::uint64_t revision, const std::string&) {
    head = revision;
    return absl::OkStatus();
  };
  visitor.entry = [&](const Journal::Entry& entry) {
    head = entry.revision;
    return absl::OkStatus();
  };
  ASSERT_TRUE(from_->Read(from_key, visitor).ok());
  const std::uint64_t oldest = *from_->Oldest(from_key);
  for (int i = 0; i < 40; ++i) {
    ++head;
    for (const auto& [journal, key] : {std::pair{from_.get(), from_key}, {to_.get(), to_key}}) {
      const Journal::Entry entry{head, std::string(150, 'e')};
      ASSERT_TRUE(journal->Append(key, entry, std::nullopt).ok());
      ASSERT_TRUE(journal->Compact(key, head, {std::string(100, 'p')}).ok());
    }
    EXPECT_EQ(*to_->Oldest(to_key), *from_->Oldest(from_key)) << i;
  }
  EXPECT_GT(*from_->Oldest(from_key), oldest);
  EXPECT_EQ(ToldAll(*to_), ToldAll(*from_));
}

TEST_F(JournalCopyTest, OnlyTheNamedMeshesAreCopied) {
  options_.meshes = {"one", "entries"};
  const auto counts = CopyMeshes(*from_, *to_, options_);
  ASSERT_TRUE(counts.ok()) << counts.status();
  EXPECT_EQ(counts->copied, 2u);
  const auto meshes = MeshesOf(*to_);
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[0].id, "entries");
  EXPECT_EQ(meshes[1].id, "one");
  options_.meshes = {"one", "twoo"};
  const absl::Status missing = CopyMeshes(*from_, *to_, options_).status();
  EXPECT_TRUE(absl::IsNotFound(missing)) << missing;
  EXPECT_TRUE(absl::StrContains(missing.message(), "twoo")) << missing;
}

// Every place at which the program may end.
TEST_F(JournalCopyTest, AnEndAtAnyWriteLeavesWholeMeshesOnlyAndTheNextCopyGoesOn) {
  const std::vector<std::string> before = ToldAll(*from_);
  int ends = 0, begun = 0;
  for (int writes = 0;; ++writes) {
    test::TempFolder folder;
    auto to = OpenSqlite(folder.path());
    EndingJournal ending(*to, writes);
    const auto ended = CopyMeshes(*from_, ending, options_);
    if (ended.ok()) break;
    ++ends;
    EXPECT_TRUE(absl::IsUnavailable(ended.status()) || absl::IsDataLoss(ended.status()))
        << ended.status();
    to.reset();
    to = OpenSqlite(folder.path());
    for (const std::string& mesh : ToldAll(*to)) {
      EXPECT_EQ(std::count(before.begin(), before.end(), mesh), 1) << writes;
      ++begun;
    }
    const auto counts = CopyMeshes(*from_, *to, options_);
    ASSERT_TRUE(counts.ok()) << counts.status();
    EXPECT_EQ(counts->copied + counts->there, 6u);
    ASSERT_EQ(ToldAll(*to), before) << writes;
  }
  EXPECT_GT(ends, 20);
  EXPECT_GT(begun, 20);
}

TEST_F(JournalCopyTest, WhatAnEndLeftBehindIsSweptAtTheNextOpening) {
  options_.meshes = {"generations"};
  EndingJournal ending(*to_, 4);
  EXPECT_FALSE(CopyMeshes(*from_, ending, options_).ok());
  EXPECT_GT(TargetRows(), 0);
  EXPECT_TRUE(to_->List()->empty());
  ReopenTarget();
  EXPECT_EQ(TargetRows(), 0);
}

TEST_F(JournalCopyTest, AnotherMeshOfThatNameIsRefusedAndNothingIsCopied) {
  JournalFiller(*to_, 7).Fill("one", 2, 3, 0);
  const std::vector<std::string> before = ToldAll(*to_);
  const absl::Status refused = CopyMeshes(*from_, *to_, options_).status();
  EXPECT_TRUE(absl::IsAlreadyExists(refused)) << refused;
  EXPECT_TRUE(absl::StrContains(refused.message(), "mesh one")) << refused;
  EXPECT_EQ(ToldAll(*to_), before);
}

TEST_F(JournalCopyTest, ACopyThatWentOnByItselfIsAnotherMesh) {
  ASSERT_TRUE(CopyMeshes(*from_, *to_, options_).ok());
  const auto again = CopyMeshes(*from_, *to_, options_);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->copied, 0u);
  EXPECT_EQ(again->there, 6u);
  const Journal::Mesh mesh = to_->List()->front();
  ASSERT_TRUE(to_->Append(mesh.key, std::nullopt, Journal::Request{"r", "a"}).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(CopyMeshes(*from_, *to_, options_).status()));
}

TEST_F(JournalCopyTest, ADamagedMeshIsNamedAndOthersCanBeCopied) {
  from_.reset();
  auto db = *sqlite::Connection::Open(from_folder_.path() + "/journal.sqlite", nullptr);
  ASSERT_TRUE(db.Run("UPDATE entries SET data = x'00' WHERE revision = 9 AND mesh = (SELECT key "
                     "FROM meshes WHERE id = 'entries')")
                  .ok());
  from_ = OpenSqlite(from_folder_.path());
  const absl::Status damaged = CopyMeshes(*from_, *to_, options_).status();
  EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
  EXPECT_TRUE(absl::StrContains(damaged.message(), "entries")) << damaged;
  for (const Journal::Mesh& mesh : MeshesOf(*to_)) EXPECT_NE(mesh.id, "entries");
  options_.meshes = {"generations", "one"};
  EXPECT_TRUE(CopyMeshes(*from_, *to_, options_).ok());
}

// The bytes of a row change between the writing and the reading.
TEST_F(JournalCopyTest, WhatIsReadBackOtherwiseIsDeleted) {
  auto db = *sqlite::Connection::Open(to_folder_.path() + "/journal.sqlite", nullptr);
  ASSERT_TRUE(db.Run("CREATE TRIGGER bad AFTER INSERT ON meshes WHEN new.id = 'generations' BEGIN "
                     "DELETE FROM requests WHERE mesh = new.key; UPDATE entries SET data = x'00' "
                     "WHERE mesh = new.key AND revision = new.head; END")
                  .ok());
  options_.meshes = {"generations"};
  const absl::Status other = CopyMeshes(*from_, *to_, options_).status();
  EXPECT_TRUE(absl::IsDataLoss(other)) << other;
  EXPECT_TRUE(absl::StrContains(other.message(), "read back")) << other;
  EXPECT_TRUE(to_->List()->empty());
  EXPECT_EQ(TargetRows(), 0);
}

TEST_F(JournalCopyTest, RowsThatAreSweptAwayAreNoticedByPublish) {
  const auto key = to_->NewKey();
  ASSERT_TRUE(key.ok()) << key.status();
  ASSERT_TRUE(to_->WriteUnseen(*key, {}, {{1, "a"}, {2, "b"}}).ok());
  while (to_->Sweep(*key)) {
  }
  MeshImport::Whole whole{"m", "", 2, {{0, 0, 0, 2}}, {}};
  const absl::Status missing = to_->Publish(*key, whole);
  EXPECT_TRUE(absl::IsFailedPrecondition(missing)) << missing;
  EXPECT_TRUE(to_->List()->empty());
  const auto next = to_->NewKey();
  EXPECT_GT(*next, *key) << "no key is given twice";
}

}  // namespace
}  // namespace dynmesh::server
