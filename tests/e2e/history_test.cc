// Earlier revisions of real meshes over gRPC: read, and reverted to, across compactions and
// restarts, each compared with a mesh made from scratch of its features.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/journal/sqlite.h"
#include "server/journal/sqlite_journal.h"
#include "server/revisions/diff_algebra.h"
#include "server/server.h"
#include "tests/support/label_script.h"
#include "tests/support/polygon_script.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"
#include "tests/support/workload.h"

namespace dynmesh::history_test {
namespace {

std::string ReasonOf(const absl::Status& status) {
  const auto error = codec::GetServiceError(status);
  return error.has_value() ? error->reason : "";
}

LabelColumn LabelsOf(const std::vector<Feature>& features) {
  LabelColumn labels;
  for (const Feature& f : features) {
    if (f.label) labels.push_back({f.id, *f.label});
  }
  return labels;
}

class HistoryTest : public ::testing::Test {
 protected:
  HistoryTest() {
    EXPECT_TRUE(server::SetLogLevel("error").ok());
    seed_ = test::NewSeed();
  }

  void Start(bool journal = true) {
    client_.reset();
    server_.reset();
    server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    config.compact_bytes = compact_bytes_;
    std::unique_ptr<server::Journal> opened;
    if (journal) opened = *server::SqliteJournal::Open(folder_.path(), journal_options_);
    server_ = *server::Server::Start(config, &DynamicMesh::Create, std::move(opened));
    client_ = client::MeshClient::Connect(server_->address());
  }

  // All snapshots that edits so far made due are in the journal.
  void WaitForSnapshots() {
    // What the strand does after an answer, too, is done when it is through the next task.
    ASSERT_TRUE(client_->Locate("m", 2, std::vector{0.5, 0.5}).ok());
    server_->registry().WaitForSnapshots();
  }

  // The expected content of a revision.
  struct Revision {
    std::vector<Feature> features;
    MeshHash hash;
  };

  template <typename Script>
  void GoBackAndForth(Script script, int dimension, int steps,
                      MeshKind kind = MeshKind::kDelaunay) {
    SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed_));
    std::mt19937_64 random(seed_);
    MeshOptions options;
    options.dimension = dimension;
    options.quality = DefaultQuality(dimension);
    options.kind = kind;
    options.limits.max_vertices = 20'000;
    ASSERT_TRUE(client_->CreateMesh("m", options).ok());
    std::unique_ptr<DynamicMesh> mirror = *DynamicMesh::Create(options);
    std::vector<Revision> past = {{{}, mirror->hash()}};
    client::EditParams params;
    params.dimension = dimension;
    for (int step = 0; step < steps; ++step) {
      SCOPED_TRACE(absl::StrCat("step ", step));
      if (random() % 6 == 0) Start();
      if (random() % 3 == 0) {
        const std::uint64_t to = random() % past.size();
        const auto reverted = client_->RevertTo("m", to);
        ASSERT_TRUE(reverted.ok()) << reverted.status();
        ASSERT_EQ(reverted->diff.hash, past[to].hash) << "as revision " << to;
        const bool changes = past[to].features != past.back().features;
        ASSERT_EQ(reverted->diff.to_revision, past.size() - (changes ? 0 : 1));
        if (changes) past.push_back(past[to]);
        mirror = *DynamicMesh::Create(options);
        ASSERT_TRUE(mirror->Apply(AddAll(past[to].features)).ok());
      } else {
        const EditBatch batch = script.Next(past.back().features);
        const auto applied = client_->Apply("m", batch, params);
        const auto mirrored = mirror->Apply(batch);
        ASSERT_EQ(applied.ok(), mirrored.ok()) << applied.status() << mirrored.status();
        if (!applied.ok() || batch.empty()) continue;
        past.push_back({mirror->Features(), mirror->hash()});
      }
      ASSERT_EQ(client_->GetMesh("m")->hash, past.back().hash);
      const auto snapshot = client_->GetSnapshot("m");
      ASSERT_TRUE(snapshot.ok()) << snapshot.status();
      ASSERT_EQ(snapshot->labels, LabelsOf(past.back().features));
      const std::uint64_t some = random() % past.size();
      for (const std::uint64_t r : {some, past.size() - 1}) {
        const auto found = client_->GetFeatures("m", r);
        ASSERT_TRUE(found.ok()) << found.status();
        ASSERT_EQ(found->revision, r);
        ASSERT_EQ(found->hash, past[r].hash);
        ASSERT_EQ(found->features, past[r].features) << "revision " << r;
      }
    }
    EXPECT_EQ(client_->GetFeatures("m")->revision, past.size() - 1);
    ASSERT_TRUE(client_->DeleteMesh("m").ok());
  }

  std::uint64_t seed_ = 0;
  test::TempFolder folder_;
  std::uint64_t compact_bytes_ = 2'000;  // often
  server::SqliteJournal::Options journal_options_;
  std::unique_ptr<server::Server> server_;
  std::unique_ptr<client::MeshClient> client_;
};

TEST_F(HistoryTest, RandomScriptsOfThePlaneGoBackToWhatTheyWere) {
  Start();
  using D = test::Distribution;
  for (const D d : {D::kUniform, D::kSized, D::kPolygons, D::kCapsules, D::kWedges, D::kGrid}) {
    SCOPED_TRACE(test::NameOf(d));
    GoBackAndForth(test::ScriptGenerator(d, 40, seed_), 2, 40);
    if (HasFatalFailure()) return;
  }
}

// Snapshots, entries, restarts and reverts have the labels of their features.
TEST_F(HistoryTest, LabelsGoBackToWhatTheyWere) {
  Start();
  using D = test::Distribution;
  for (const D d : {D::kUniform, D::kSized, D::kPolygons, D::kGridEdges}) {
    SCOPED_TRACE(test::NameOf(d));
    test::LabelledScript script(test::ScriptGenerator(d, 30, seed_), seed_ + 1);
    GoBackAndForth(script, test::DimensionOf(d), 30);
    if (HasFatalFailure()) return;
  }
}

TEST_F(HistoryTest, QuadtreesGoBackToWhatTheyWere) {
  Start();
  using D = test::Distribution;
  for (const D d : {D::kUniform, D::kSegmentsTurned, D::kWedges, D::kTurnedGridEdges}) {
    SCOPED_TRACE(test::NameOf(d));
    GoBackAndForth(test::ScriptGenerator(d, 40, seed_), test::DimensionOf(d), 40,
                   MeshKind::kQuadtree);
    if (HasFatalFailure()) return;
  }
}

TEST_F(HistoryTest, RandomScriptsOfSpaceGoBackToWhatTheyWere) {
  Start();
  using K = test::PolygonKind;
  for (const K kind : {K::kMixture, K::kHoled}) {
    SCOPED_TRACE(test::NameOf(kind));
    GoBackAndForth(test::PolygonScript(kind, 2, seed_), 3, 12);
    if (HasFatalFailure()) return;
  }
  GoBackAndForth(test::ScriptGenerator(test::Distribution::kSpaceSized, 15, seed_), 3, 12);
}

TEST_F(HistoryTest, DamagedMeshesAreListed) {
  Start();
  for (const char* id : {"bad", "good"}) {
    ASSERT_TRUE(client_->CreateMesh(id, MeshOptions()).ok());
    ASSERT_TRUE(client_->Apply(id, {Edit::Add(Feature::Point(1, 0.25, 0.5))}).ok());
  }
  client_.reset();
  server_.reset();
  {
    auto file = server::sqlite::Connection::Open(folder_.path() + "/journal.sqlite", nullptr);
    ASSERT_TRUE(file.ok()) << file.status();
    ASSERT_TRUE(file->Run("UPDATE entries SET data = x'ff' WHERE mesh = (SELECT key FROM meshes "
                          "WHERE id = 'bad')")
                    .ok());
  }
  Start();
  const auto meshes = client_->ListMeshes();
  ASSERT_TRUE(meshes.ok()) << meshes.status();
  ASSERT_EQ(meshes->size(), 2u);
  EXPECT_EQ((*meshes)[0].id, "bad");
  EXPECT_EQ((*meshes)[0].damage, client_->GetMesh("bad").status().message());
  EXPECT_EQ(ReasonOf(client_->GetMesh("bad").status()), codec::reason::kMeshDamaged);
  EXPECT_EQ((*meshes)[1].id, "good");
  EXPECT_EQ((*meshes)[1].damage, "");
  EXPECT_EQ((*meshes)[1].revision, 1u);
}

TEST_F(HistoryTest, WhatIsTooOldOrNotYetThereIsSaid) {
  compact_bytes_ = 0;  // a generation for each edit
  journal_options_.history_bytes = 0;
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  // Another point, and all others set to what they are: more bytes than the last snapshot has.
  EditBatch batch;
  const auto add = [&](FeatureId id) {
    for (Edit& edit : batch) edit.action = Edit::Action::kSet;
    batch.push_back(Edit::Add(Feature::Point(id, 0.05 * static_cast<double>(id), 0.5)));
    absl::Status status = client_->Apply("m", batch).status();
    WaitForSnapshots();
    return status;
  };
  for (FeatureId id = 1; id <= 6; ++id) ASSERT_TRUE(add(id).ok());
  EXPECT_EQ(client_->GetFeatures("m", 5)->features.size(), 5u);
  for (const absl::Status& old :
       {client_->GetFeatures("m", 2).status(), client_->RevertTo("m", 2).status()}) {
    EXPECT_EQ(old.code(), absl::StatusCode::kOutOfRange) << old;
    ASSERT_EQ(ReasonOf(old), codec::reason::kCompacted);
    EXPECT_EQ(codec::GetServiceError(old)->metadata["oldest_revision"], "5");
  }
  for (const absl::Status& future :
       {client_->GetFeatures("m", 7).status(), client_->RevertTo("m", 7).status()}) {
    EXPECT_EQ(future.code(), absl::StatusCode::kOutOfRange) << future;
    EXPECT_EQ(ReasonOf(future), codec::reason::kFutureRevision);
  }
  EXPECT_EQ(ReasonOf(client_->GetFeatures("none").status()), codec::reason::kMeshNotFound);

  // To the present one: nothing to do.
  const auto nothing = client_->RevertTo("m", 6);
  ASSERT_TRUE(nothing.ok()) << nothing.status();
  EXPECT_EQ(nothing->diff.from_revision, 6u);
  EXPECT_EQ(nothing->diff.to_revision, 6u);

  client::EditParams params;
  params.expected_revision = 5;
  params.request_id = "back";
  EXPECT_EQ(ReasonOf(client_->RevertTo("m", 5, params).status()), codec::reason::kRevisionMismatch);
  params.expected_revision = 6;
  const auto back = client_->RevertTo("m", 5, params);
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->diff.to_revision, 7u);
  EXPECT_FALSE(back->replayed);
  // A retry is answered when the revision is long gone, and after a restart, too.
  batch.pop_back();
  for (FeatureId id = 11; id <= 14; ++id) ASSERT_TRUE(add(id).ok());
  EXPECT_EQ(ReasonOf(client_->GetFeatures("m", 5).status()), codec::reason::kCompacted);
  for (int i = 0; i < 2; ++i) {
    const auto again = client_->RevertTo("m", 5, params);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_TRUE(again->replayed);
    EXPECT_EQ(again->diff.to_revision, 7u);
    EXPECT_EQ(again->diff.hash, back->diff.hash);
    EXPECT_EQ(ReasonOf(client_->RevertTo("m", 6, params).status()),
              codec::reason::kRequestIdReused);
    Start();
  }
}

TEST_F(HistoryTest, WithoutAJournalThereIsThePresentOnly) {
  Start(/*journal=*/false);
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  EXPECT_EQ(client_->GetFeatures("m")->features.size(), 0u);
  const std::vector<Feature> features = {Feature::Point(3, 0.25, 0.5), Feature::Point(9, 0.5, 0.5)};
  const auto applied = client_->AddFeatures("m", features);
  ASSERT_TRUE(applied.ok()) << applied.status();
  for (const auto& found : {client_->GetFeatures("m"), client_->GetFeatures("m", 1)}) {
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->features, features);
    EXPECT_EQ(found->revision, 1u);
    EXPECT_EQ(found->hash, applied->diff.hash);
  }
  EXPECT_EQ(ReasonOf(client_->GetFeatures("m", 2).status()), codec::reason::kFutureRevision);
  for (const absl::Status& none :
       {client_->GetFeatures("m", 0).status(), client_->RevertTo("m", 0).status()}) {
    EXPECT_EQ(none.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_EQ(ReasonOf(none), codec::reason::kNoHistory);
    EXPECT_TRUE(absl::StrContains(none.message(), "--data-dir")) << none;
  }
}

// What the server does not hold after its start, and the journal has.
TEST_F(HistoryTest, AWatchBeginsInTheJournalsPast) {
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed_));
  journal_options_.history_bytes = 10'000;
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  const std::unique_ptr<DynamicMesh> mirror = *DynamicMesh::Create(MeshOptions());
  std::vector<Mesh> past = {mirror->Snapshot()};
  test::ScriptGenerator script(test::Distribution::kUniform, 40, seed_);
  while (past.size() < 300) {
    const EditBatch batch = script.Next(mirror->Features());
    if (batch.empty() || !mirror->Apply(batch).ok()) continue;
    ASSERT_TRUE(client_->Apply("m", batch).ok());
    past.push_back(mirror->Snapshot());
  }
  WaitForSnapshots();
  Start();
  const std::uint64_t held = client_->GetStats("m")->mesh->oldest_revision;
  std::uint64_t oldest = 0;
  // Each snapshot may drop a generation.
  const auto find_oldest = [&] {
    WaitForSnapshots();
    while (!client_->GetFeatures("m", oldest).ok()) ++oldest;
  };
  find_oldest();
  ASSERT_GT(held, oldest) << "the test shows nothing";
  ASSERT_GT(oldest, 0u);
  const auto stream_from = [&](std::uint64_t revision, const MeshHash& hash) {
    client::DiffStreamOptions options;
    options.start_revision = revision;
    options.start_hash = hash;
    return client_->StreamDiffs("m", options);
  };
  for (const std::uint64_t wanted : {oldest, (oldest + held) / 2, held - 1, held}) {
    // The edits of the rounds before may have made one.
    find_oldest();
    const std::uint64_t from = std::max(wanted, oldest);
    SCOPED_TRACE(absl::StrCat("from revision ", from, ", held from ", held));
    const auto stream = stream_from(from, past[from].hash);
    Mesh mesh = past[from];
    for (std::uint64_t r = from + 1; r < past.size(); ++r) {
      const auto event = stream->Next(absl::Minutes(1));
      ASSERT_TRUE(event.ok()) << event.status();
      ASSERT_TRUE(event->has_value());
      const MeshDiff& diff = std::get<MeshDiff>(**event);
      ASSERT_EQ(diff.to_revision, r);
      mesh = *server::Patched(mesh, diff);
      ASSERT_EQ(mesh.hash, past[r].hash);
      ASSERT_EQ(ComputeHash(mesh), past[r].hash);
    }
    // It goes on, and back.
    ASSERT_TRUE(client_->Apply("m", {Edit::Add(Feature::Point(9'999, 0.777, 0.123))}).ok());
    const auto event = stream->Next(absl::Minutes(1));
    ASSERT_TRUE(event.ok() && event->has_value()) << event.status();
    EXPECT_EQ(std::get<MeshDiff>(**event).to_revision, past.size());
    const auto next = client_->GetSnapshot("m");
    ASSERT_TRUE(next.ok()) << next.status();
    past.push_back(*next);
    ASSERT_TRUE(client_->RemoveFeatures("m", std::vector<FeatureId>{9'999}).ok());
    past.push_back(*client_->GetSnapshot("m"));
  }
  const auto ends_with = [](client::DiffStream& stream) {
    return ReasonOf(stream.Next(absl::Minutes(1)).status());
  };
  find_oldest();
  EXPECT_EQ(ends_with(*stream_from(oldest + 1, past[oldest].hash)), codec::reason::kDiverged);
  EXPECT_EQ(ends_with(*stream_from(oldest - 1, past[oldest - 1].hash)), codec::reason::kCompacted);
}

// More than a chunk has.
TEST_F(HistoryTest, ManyFeaturesComeInChunks) {
  Start();
  ASSERT_TRUE(client_->CreateMesh("m", MeshOptions()).ok());
  std::vector<Feature> features;
  for (FeatureId id = 1; id <= 40'000; ++id) {
    features.push_back(Feature::SizeAt(id, static_cast<double>(id % 200) / 200,
                                       static_cast<double>(id / 200) / 201, 10));
  }
  ASSERT_TRUE(client_->AddFeatures("m", features).ok());
  const auto found = client_->GetFeatures("m");
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->features, features);
}

}  // namespace
}  // namespace dynmesh::history_test
