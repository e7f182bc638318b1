// Recovered meshes: as they were, or reported as damaged.
#include "server/meshes/recovery.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "proto/codec/journal_codec.h"
#include "server/base/log.h"
#include "server/meshes/revert_plan.h"
#include "tests/server/journal/durable_registry.h"
#include "tests/server/journal/forwarding_journal.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::recovery_test {
namespace {

using absl::StatusCode;

class RecoveryTest : public ::testing::Test {
 protected:
  RecoveryTest() { EXPECT_TRUE(SetLogLevel("off").ok()); }

  void Open() {
    server_.reset();
    server_ = std::make_unique<DurableRegistry>(folder_.path(), config_, nullptr, accept_);
    ASSERT_TRUE(server_->status().ok()) << server_->status();
  }
  // With mesh m of points 1..n, one a batch, with request_ids r1..rn.
  void OpenWithPoints(FeatureId n) {
    Open();
    ASSERT_TRUE((*server_)->Create("m", MeshOptions(), "made").ok());
    for (FeatureId id = 1; id <= n; ++id) {
      ASSERT_TRUE(server_->Apply({AddPoint(id)}, absl::StrCat("r", id)).ok());
    }
  }
  // Of the first mesh: the revision of its snapshot, 0 if there is none, and how many batches
  // follow.
  std::pair<std::uint64_t, std::uint64_t> Generation() {
    std::uint64_t snapshot = 0, entries = 0;
    Journal::Visitor count;
    count.request = [](const Journal::Request&) { return absl::OkStatus(); };
    count.snapshot = [&](std::uint64_t revision, const std::string&) {
      snapshot = revision;
      return absl::OkStatus();
    };
    count.entry = [&](const Journal::Entry&) {
      ++entries;
      return absl::OkStatus();
    };
    EXPECT_TRUE(server_->journal().Read(server_->journal().List()->front().key, count).ok());
    return {snapshot, entries};
  }
  // Changes the closed database.
  void Sql(const char* sql) {
    server_.reset();
    auto db = sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    ASSERT_TRUE(db.ok());
    const absl::Status status = db->Run(sql);
    ASSERT_TRUE(status.ok()) << status;
  }

  test::TempFolder folder_;
  ServerConfig config_;
  std::vector<std::string> accept_;
  std::unique_ptr<DurableRegistry> server_;
};

TEST_F(RecoveryTest, MeshesComeBackAsTheyWere) {
  OpenWithPoints(5);
  MeshOptions options;
  options.box.hi = {2, 3, 1};
  options.quality = 1.25;
  options.limits.max_vertices = 1'000;
  options.max_edge = 0.5;
  ASSERT_TRUE((*server_)->Create("other", options, "").ok());
  ASSERT_TRUE((*server_)->Create("gone", options, "gone-id").ok());
  ASSERT_TRUE((*server_)->Delete("meshes/gone").ok());
  const Head head = server_->Host()->head();
  const absl::Time created = server_->Host()->create_time();
  const Mesh before = **server_->Host()->store()->Latest();
  for (int i = 0; i < 2; ++i) {
    Open();
    EXPECT_EQ((*server_)->size(), 2u);
    const auto host = server_->Host();
    EXPECT_EQ(host->head().revision, 5u);
    EXPECT_EQ(host->head().hash, head.hash);
    EXPECT_EQ(host->create_time(), created);
    EXPECT_EQ(host->stats().features, 5u);
    Mesh after = **host->store()->Latest();
    EXPECT_EQ(ComputeHash(after), head.hash);
    EXPECT_EQ(after.vertices.size(), before.vertices.size());
    EXPECT_EQ(server_->Host("other")->mesh_options(), options);
    EXPECT_EQ(ReasonOf((*server_)->Find("meshes/gone").status()), codec::reason::kMeshNotFound);
    // The retry of the creation finds it; that of the deleted one makes another.
    EXPECT_EQ(*(*server_)->Create("m", MeshOptions(), "made"), host);
    EXPECT_EQ(ReasonOf((*server_)->Create("m", MeshOptions(), "").status()),
              codec::reason::kMeshExists);
  }
  EXPECT_EQ(server_->Apply({AddPoint(6)})->diff->to_revision, 6u);
}

TEST_F(RecoveryTest, RetriesAreAnsweredAsTheFirstTime) {
  config_.compact_bytes = 150;
  OpenWithPoints(6);
  ASSERT_TRUE(server_->Apply({}, "empty").ok());
  ASSERT_TRUE(server_->Apply({AddPoint(7)}, "r7").ok());
  Open();
  const auto first = server_->Apply({AddPoint(1)}, "r1");
  ASSERT_TRUE(first.ok());
  EXPECT_TRUE(first->replayed);
  EXPECT_EQ(first->diff->to_revision, 1u);
  EXPECT_TRUE(first->columns_omitted);  // a snapshot took its place
  const auto last = server_->Apply({AddPoint(7)}, "r7");
  ASSERT_TRUE(last.ok());
  EXPECT_EQ(last->diff->to_revision, 7u);
  EXPECT_TRUE(server_->Apply({}, "empty")->replayed);
  EXPECT_EQ(ReasonOf(server_->Apply({AddPoint(9)}, "r2").status()),
            codec::reason::kRequestIdReused);
  EXPECT_EQ(server_->Host()->head().revision, 7u);
}

TEST_F(RecoveryTest, ASnapshotTakesThePlaceOfManyEdits) {
  config_.compact_bytes = 200;
  OpenWithPoints(1);
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(server_->Apply({i % 2 == 0 ? AddPoint(2) : Edit::Remove(2)}).ok());
  }
  const Head head = server_->Host()->head();
  const auto [snapshot, entries] = Generation();
  EXPECT_GT(snapshot, 30u);
  EXPECT_LT(entries, 8u);
  Open();
  EXPECT_EQ(server_->Host()->head().revision, 41u);
  EXPECT_EQ(server_->Host()->head().hash, head.hash);
}

TEST_F(RecoveryTest, ASnapshotIsDueForMuchWorkInFewBytes) {
  config_.compact_operations = 10;  // of the fake mesh, one for each edit
  OpenWithPoints(1);
  for (int i = 0; i < 25; ++i) {
    ASSERT_TRUE(server_->Apply({i % 2 == 0 ? AddPoint(2) : Edit::Remove(2)}).ok());
  }
  EXPECT_EQ(Generation(), std::pair(std::uint64_t{23}, std::uint64_t{3}));
  Open();  // the work of what was done again counts as well
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(server_->Apply({i % 2 == 0 ? Edit::Remove(2) : AddPoint(2)}).ok());
  }
  EXPECT_EQ(Generation(), std::pair(std::uint64_t{34}, std::uint64_t{0}));
}

TEST_F(RecoveryTest, AFirstLoadIsAsGoodAsASnapshot) {
  config_.compact_bytes = 200;
  Open();
  ASSERT_TRUE((*server_)->Create("m", MeshOptions(), "").ok());
  EditBatch load;
  for (FeatureId id = 1; id <= 100; ++id) load.push_back(AddPoint(id));
  ASSERT_TRUE(server_->Apply(load).ok());
  ASSERT_TRUE(server_->Apply({AddPoint(101)}).ok());
  EXPECT_EQ(Generation(), std::pair(std::uint64_t{0}, std::uint64_t{2}));
  Open();
  ASSERT_TRUE(server_->Apply({AddPoint(102)}).ok());
  EXPECT_EQ(Generation(), std::pair(std::uint64_t{0}, std::uint64_t{3}));
}

TEST_F(RecoveryTest, AnEmptyMeshKeepsItsRevisionThroughASnapshot) {
  config_.compact_bytes = 0;
  OpenWithPoints(1);
  ASSERT_TRUE(server_->Apply({Edit::Remove(1)}).ok());
  Open();
  EXPECT_EQ(server_->Host()->head().revision, 2u);
  EXPECT_EQ(server_->Apply({AddPoint(1)})->diff->from_revision, 2u);
}

TEST_F(RecoveryTest, WatchersGoOnWhereTheyWere) {
  OpenWithPoints(4);
  const MeshHash at2 = *server_->Host()->store()->HashAt(2);
  Open();
  const auto host = server_->Host();
  EXPECT_TRUE(host->hub()->Subscribe({.revision = 4, .hash = host->head().hash}, [] {}).ok());
  EXPECT_TRUE(host->hub()->Subscribe({.revision = 2, .hash = at2}, [] {}).ok());
  EXPECT_EQ(host->store()->DiffsFrom(0)->size(), 4u);

  config_.compact_bytes = 0;  // from the next edit on
  Open();
  ASSERT_TRUE(server_->Apply({AddPoint(5)}).ok());
  Open();
  EXPECT_EQ(ReasonOf(server_->Host()->hub()->Subscribe({.revision = 2}, [] {}).status()),
            codec::reason::kCompacted);
  EXPECT_TRUE(server_->Host()->hub()->Subscribe({.revision = 5}, [] {}).ok());
}

TEST_F(RecoveryTest, WhatDoesNotMakeTheMeshAgainIsDamageOfThatMeshAlone) {
  const std::pair<const char*, const char*> damages[] = {
      {"UPDATE entries SET data = x'ffff' WHERE revision = 2", "entry of revision 2 is damaged"},
      {"UPDATE entries SET data = x'' WHERE revision = 3", "revision 3"},
      {"UPDATE entries SET data = (SELECT data FROM entries WHERE revision = 1) WHERE revision = 3",
       "revision 3"},
      {"DELETE FROM entries WHERE revision = 2", "some are missing"},
      {"DELETE FROM entries WHERE revision = 3", "some are missing"},
      {"UPDATE meshes SET head = 7", "some are missing"},
      {"UPDATE meshes SET description = x'01' WHERE id = 'm'", "the description is damaged"},
      {"UPDATE meshes SET snapshot = 1", "the snapshot of revision 1, or a part of it, is missing"},
      {"UPDATE meshes SET head = 2", "some are missing"},
      {"UPDATE requests SET answer = x'ff'", "request r1 is damaged"},
  };
  for (const auto& [sql, what] : damages) {
    SCOPED_TRACE(sql);
    server_.reset();
    std::filesystem::remove_all(folder_.path());
    OpenWithPoints(3);
    Sql(sql);
    Open();
    ASSERT_TRUE((*server_)->Create("sound", MeshOptions(), "").ok());
    ASSERT_TRUE(server_->Apply({AddPoint(1)}, "", "sound").ok());
    Open();
    EXPECT_EQ(server_->Host("sound")->head().revision, 1u);
    const absl::Status damage = (*server_)->Find("meshes/m").status();
    EXPECT_EQ(damage.code(), StatusCode::kDataLoss);
    EXPECT_EQ(ReasonOf(damage), codec::reason::kMeshDamaged);
    EXPECT_TRUE(absl::StrContains(damage.message(), "meshes/m")) << damage;
    EXPECT_TRUE(absl::StrContains(damage.message(), what)) << damage;
    EXPECT_EQ((*server_)->Create("m", MeshOptions(), "made").status(), damage);
    const auto listed = (*server_)->List("", 10);
    ASSERT_EQ(listed.size(), 2u);
    EXPECT_EQ(listed[0].id, "m");
    EXPECT_EQ(listed[0].host, nullptr);
    EXPECT_EQ(listed[0].damage, damage);
    EXPECT_EQ(listed[1].host, server_->Host("sound"));
    EXPECT_EQ((*server_)->Hosts().size(), 1u);
    // It can be deleted, and made anew.
    ASSERT_TRUE((*server_)->Delete("meshes/m").ok());
    ASSERT_TRUE((*server_)->Create("m", MeshOptions(), "made").ok());
    Open();
    EXPECT_EQ(server_->Host()->head().revision, 0u);
  }
}

TEST_F(RecoveryTest, AMeshThatLostRevisionsIsReadOnlyUntilThatIsAccepted) {
  OpenWithPoints(3);
  test::TempFolder before;
  CopyJournal(folder_.path(), before.path());
  ASSERT_TRUE((*server_)->Create("gone", MeshOptions(), "").ok());
  ASSERT_TRUE(server_->Apply({AddPoint(4)}, "r4").ok());
  server_.reset();
  for (const char* file : {"journal.sqlite", "journal.sqlite-wal"}) {
    const auto to = std::filesystem::path(folder_.path()) / file;
    std::filesystem::remove(to);
    std::filesystem::copy(std::filesystem::path(before.path()) / file, to);
  }
  Open();
  EXPECT_EQ((*server_)->damaged(), 2u);
  const auto host = server_->Host();
  EXPECT_EQ(host->head().revision, 3u);
  const absl::Status refused = server_->Apply({AddPoint(4)}, "r4").status();
  EXPECT_EQ(refused.code(), StatusCode::kDataLoss);
  EXPECT_EQ(ReasonOf(refused), codec::reason::kMeshDamaged);
  EXPECT_TRUE(absl::StrContains(refused.message(), "revision 4 was acknowledged")) << refused;
  EXPECT_TRUE(absl::StrContains(refused.message(), "--accept-loss=m@3")) << refused;
  // The rest can be read, and answered requests are answered again.
  EXPECT_TRUE(server_->Apply({AddPoint(3)}, "r3")->replayed);
  Mailbox<absl::StatusOr<FeaturesAt>> features;
  ASSERT_TRUE(host->Features(2, nullptr, [&](auto f) { features.Put(std::move(f)); }).ok());
  EXPECT_EQ(features.Take()->features.size(), 2u);
  EXPECT_EQ((*host->store()->Latest())->revision, 3u);
  const auto listed = (*server_)->List("", 10);
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0].id, "gone");
  EXPECT_EQ(listed[0].host, nullptr);
  EXPECT_EQ(ReasonOf((*server_)->Find("meshes/gone").status()), codec::reason::kMeshDamaged);
  EXPECT_EQ(ReasonOf((*server_)->Create("gone", MeshOptions(), "").status()),
            codec::reason::kMeshDamaged);
  EXPECT_EQ(listed[1].host, host);
  EXPECT_EQ(listed[1].damage, refused);
  ASSERT_TRUE((*server_)->Delete("meshes/gone").ok());
  ASSERT_TRUE((*server_)->Create("gone", MeshOptions(), "").ok());
  ASSERT_TRUE(server_->Apply({AddPoint(1)}, "", "gone").ok());
  accept_ = {"m@3"};
  Open();
  EXPECT_EQ((*server_)->damaged(), 0u);
  EXPECT_EQ(server_->Apply({AddPoint(4)}, "r4")->diff->to_revision, 4u);
  EXPECT_EQ(server_->Host("gone")->head().revision, 1u);
  accept_.clear();
  Open();
  EXPECT_EQ((*server_)->damaged(), 0u);
}

// A bad row does not affect the others, whatever its content.
TEST_F(RecoveryTest, AMeshWithAnUnspeakableNameIsListedAndDeleted) {
  for (const bool record : {true, false}) {
    server_.reset();
    std::filesystem::remove_all(folder_.path());
    OpenWithPoints(1);
    ASSERT_TRUE((*server_)->Create("sound", MeshOptions(), "").ok());
    Sql("UPDATE meshes SET id = CAST(X'6DB3' AS TEXT) WHERE key = 1");
    if (!record) std::filesystem::remove(folder_.path() + "/journal.heads");
    if (!record) accept_ = {"sound@0"};
    Open();
    const auto listed = (*server_)->List("", 10);
    ASSERT_EQ(listed.size(), 2u);
    const std::string name = record ? "m" : "@1";
    EXPECT_EQ(listed[0].id, name);
    EXPECT_EQ(ReasonOf(listed[0].damage), codec::reason::kMeshDamaged);
    EXPECT_TRUE(absl::StrContains(listed[0].damage.message(), "m\\xb3")) << listed[0].damage;
    EXPECT_EQ((*server_)->List(name, 10).front().id, "sound");  // the next page
    EXPECT_EQ(ReasonOf((*server_)->Create("@1", MeshOptions(), "").status()),
              codec::reason::kBadName);
    ASSERT_TRUE((*server_)->Delete("meshes/" + name).ok());
    Open();
    EXPECT_EQ((*server_)->size(), 1u);
    EXPECT_TRUE(server_->Apply({AddPoint(1)}, "", "sound").ok());
    accept_.clear();
  }
}

// The file overwritten anywhere: only acknowledged data is served.
TEST_F(RecoveryTest, AnOverwrittenFileIsNeverServedAsAnotherMesh) {
  OpenWithPoints(30);
  const MeshHash hash = server_->Host()->head().hash;
  server_.reset();
  const std::string file = folder_.path() + "/journal.sqlite";
  const auto size = static_cast<int>(std::filesystem::file_size(file));
  int noticed = 0;
  for (int at = 0; at + 256 <= size; at += 512) {
    test::TempFolder copy;
    CopyJournal(folder_.path(), copy.path());
    std::fstream out(copy.path() + "/journal.sqlite",
                     std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(at);
    out << std::string(256, '\x5a');
    out.close();
    DurableRegistry server(copy.path());
    if (!server.status().ok()) {
      ++noticed;
      continue;
    }
    const auto host = server->Find("meshes/m");
    if (!host.ok()) {
      ++noticed;
    } else {
      EXPECT_EQ((*host)->head().revision, 30u) << "at " << at;
      EXPECT_EQ((*host)->head().hash, hash) << "at " << at;
    }
  }
  EXPECT_GT(noticed, 5);
}

// --- Other bits (kMeshBits) -------------------------------------------------------------

// One whose first reads fail, as while a database starts.
class UnreachableJournal final : public ForwardingJournal {
 public:
  UnreachableJournal(Journal& inner, int failures, StatusCode code)
      : ForwardingJournal(inner), failures_(failures), code_(code) {}

  // Breaks off behind the first entry.
  absl::Status Read(Key mesh, const Visitor& visitor) override {
    if (failures_ == 0) return ForwardingJournal::Read(mesh, visitor);
    --failures_;
    Visitor cut = visitor;
    int entries = 0;
    cut.entry = [&](const Entry& entry) {
      if (++entries > 1) return absl::Status(code_, "the connection was lost");
      return visitor.entry(entry);
    };
    return ForwardingJournal::Read(mesh, cut);
  }

 private:
  int failures_;
  const StatusCode code_;
};

TEST_F(RecoveryTest, AJournalThatDoesNotAnswerForAWhileIsNoDamage) {
  OpenWithPoints(5);
  const MeshHash hash = server_->Host()->head().hash;
  WorkerPool writers(1), readers(1);
  for (const StatusCode code : {StatusCode::kUnavailable, StatusCode::kDataLoss}) {
    UnreachableJournal journal(server_->journal(), 2, code);
    MeshRegistry registry(
        config_, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); }, &writers,
        &readers, &journal);
    ASSERT_TRUE(registry.Recover().ok());
    const auto host = registry.Find("meshes/m");
    if (code == StatusCode::kDataLoss) {  // asked once
      EXPECT_EQ(ReasonOf(host.status()), codec::reason::kMeshDamaged);
      continue;
    }
    ASSERT_TRUE(host.ok()) << host.status();
    EXPECT_EQ((*host)->head().revision, 5U);
    EXPECT_EQ((*host)->head().hash, hash);
    EXPECT_EQ(registry.damaged(), 0U);
  }
}

class OtherBitsTest : public RecoveryTest {
 protected:
  // Mesh m as another version's program wrote it: points 1..n, one a batch, hashes {7, revision}.
  void OpenWithOldPoints(FeatureId n) {
    Open();
    ASSERT_TRUE((*server_)->Create("m", MeshOptions(), "").ok());
    for (FeatureId id = 1; id <= n; ++id) Append(id, {AddPoint(id)}, {7, id}, 1);
  }
  void Append(std::uint64_t revision, const EditBatch& edits, const MeshHash& hash,
              std::uint32_t bits) {
    Journal& journal = server_->journal();
    const Journal::Entry entry{revision, codec::EncodeJournalEntry(edits, hash, 2, bits)};
    ASSERT_TRUE(journal.Append(journal.List()->front().key, entry, std::nullopt).ok());
  }
  MeshHash HashOfPoints(FeatureId n) {
    auto mesh = *MakeFake(MeshOptions());
    for (FeatureId id = 1; id <= n; ++id) EXPECT_TRUE(mesh->Apply({AddPoint(id)}, {}).ok());
    return mesh->hash();
  }
  FeaturesAt FeaturesOf(std::uint64_t revision) {
    Mailbox<absl::StatusOr<FeaturesAt>> features;
    EXPECT_TRUE(server_->Host()
                    ->Features(revision, nullptr, [&](auto f) { features.Put(std::move(f)); })
                    .ok());
    return *features.Take();
  }
};

TEST_F(OtherBitsTest, TheirFeaturesAreMeshedAnewAsTheNextRevision) {
  for (const bool snapshot : {false, true}) {
    SCOPED_TRACE(snapshot);
    server_.reset();
    std::filesystem::remove_all(folder_.path());
    OpenWithOldPoints(3);
    if (snapshot) {
      std::vector<Feature> features;
      for (FeatureId id = 1; id <= 3; ++id) features.push_back(AddPoint(id).feature);
      const auto parts = codec::EncodeJournalSnapshot(features, {7, 3}, 2, 1);
      Journal& journal = server_->journal();
      ASSERT_TRUE(journal.Compact(journal.List()->front().key, 3, parts).ok());
    }
    Append(4, {AddPoint(4)}, {7, 4}, 1);
    Append(5, {Edit::Remove(4)}, {7, 5}, 1);
    Open();
    const auto host = server_->Host();
    EXPECT_EQ(host->head().revision, 6u);
    EXPECT_EQ(host->head().hash, HashOfPoints(3));
    EXPECT_EQ(Generation(), std::pair(std::uint64_t{6}, std::uint64_t{0}));
    // The history stays the same, as features.
    EXPECT_EQ(FeaturesOf(4).features.size(), 4u);
    EXPECT_EQ(FeaturesOf(4).hash, (MeshHash{7, 4}));
    EXPECT_EQ(FeaturesOf(6).features.size(), 3u);
    EXPECT_EQ(ReasonOf(host->hub()->Subscribe({.revision = 5}, [] {}).status()),
              codec::reason::kCompacted);
    EXPECT_TRUE(host->hub()->Subscribe({.revision = 6}, [] {}).ok());
    // A hash of other bits is none to expect.
    EXPECT_FALSE(PlanRevert(*host, 4, nullptr).job.expected_hash.has_value());
    EXPECT_EQ(PlanRevert(*host, 6, nullptr).job.expected_hash, HashOfPoints(3));
    EXPECT_EQ(server_->Apply({AddPoint(4)})->diff->to_revision, 7u);
    Open();
    EXPECT_EQ(server_->Host()->head().revision, 7u);
    EXPECT_EQ(server_->Host()->head().hash, HashOfPoints(4));
  }
}

TEST_F(OtherBitsTest, ASnapshotThatWasNotWrittenIsNotMissed) {
  for (const bool sound : {true, false}) {
    SCOPED_TRACE(sound);
    server_.reset();
    std::filesystem::remove_all(folder_.path());
    OpenWithOldPoints(3);
    Append(4, {}, sound ? HashOfPoints(3) : MeshHash{7, 4}, kMeshBits);
    Append(5, {AddPoint(4)}, HashOfPoints(4), kMeshBits);
    Open();
    if (sound) {
      EXPECT_EQ(server_->Host()->head().revision, 5u);
      EXPECT_EQ(server_->Host()->head().hash, HashOfPoints(4));
      EXPECT_TRUE(server_->Host()->hub()->Subscribe({.revision = 4}, [] {}).ok());
    } else {
      const absl::Status damage = (*server_)->Find("meshes/m").status();
      EXPECT_TRUE(absl::StrContains(damage.message(), "revision 4 recovered has the hash"))
          << damage;
    }
  }
}

TEST_F(OtherBitsTest, AnEmptyMeshHasNone) {
  OpenWithOldPoints(0);
  Open();
  EXPECT_EQ(server_->Host()->head().revision, 0u);
}

}  // namespace
}  // namespace dynmesh::server::recovery_test
