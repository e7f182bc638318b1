// The replica: follows diffs, and detects every kind of invalid stream.
#include "dynmesh/client/mesh_replica.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/mesh_data/diff_meshes.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "proto/codec/mesh_codec.h"
#include "tests/core/mesh_data/made_up_mesh.h"
#include "tests/server/fake_dynamic_mesh.h"
#include "tests/server/test_support.h"

namespace dynmesh::client::mesh_replica_test {
namespace {

using server::AddPoint;
using server::FakeDynamicMesh;
using Events = std::vector<v1::WatchEvent>;

Events SnapshotEvents(const Mesh& mesh, std::size_t bytes = 200) {
  Events events;
  codec::SnapshotFragmenter fragmenter(std::make_shared<Mesh>(mesh), bytes);
  v1::WatchEvent event;
  while (fragmenter.Next(event.mutable_snapshot())) events.push_back(event);
  return events;
}

Events DiffEvents(const MeshDiff& diff, std::size_t bytes = 200) {
  Events events;
  codec::DiffFragmenter fragmenter(std::make_shared<MeshDiff>(diff), false, bytes);
  v1::WatchEvent event;
  while (fragmenter.Next(event.mutable_diff())) events.push_back(event);
  return events;
}

v1::WatchEvent ProgressEvent(std::uint64_t revision, const MeshHash& hash) {
  v1::WatchEvent event;
  event.mutable_progress()->set_revision(revision);
  event.mutable_progress()->set_hash(hash.ToHex());
  return event;
}

class MeshReplicaTest : public ::testing::Test {
 protected:
  MeshReplicaTest() {
    EditBatch start;
    for (FeatureId id = 100; id < 130; ++id) start.push_back(AddPoint(id));
    start.push_back(Edit::Add(Feature::Segment(500, 100, 101)));
    EXPECT_TRUE(fake_.Apply(start, {}).ok());
    start_ = fake_.Snapshot();
    for (FeatureId id = 1; id <= 6; ++id) {
      EditBatch batch = {AddPoint(id), Edit::Remove(100 + 2 * id)};
      diffs_.push_back(*fake_.Apply(batch, {}));
    }
  }

  absl::Status Feed(const Events& events) {
    for (const auto& event : events) {
      const auto change = replica_.Take(event);
      if (!change.ok()) return change.status();
    }
    return absl::OkStatus();
  }

  FakeDynamicMesh fake_{MeshOptions(), nullptr};
  Mesh start_;
  std::vector<MeshDiff> diffs_;
  MeshReplica replica_;
};

TEST_F(MeshReplicaTest, FollowsSnapshotAndDiffsInFragments) {
  EXPECT_EQ(replica_.state(), MeshReplica::State::kEmpty);
  ASSERT_GT(SnapshotEvents(start_).size(), 3u);
  ASSERT_TRUE(Feed(SnapshotEvents(start_)).ok());
  EXPECT_EQ(replica_.state(), MeshReplica::State::kLive);
  EXPECT_EQ(replica_.hash(), start_.hash);
  for (const MeshDiff& diff : diffs_) {
    ASSERT_GT(DiffEvents(diff, 50).size(), 1u);
    ASSERT_TRUE(Feed(DiffEvents(diff, 50)).ok());
    EXPECT_EQ(replica_.revision(), diff.to_revision);
    EXPECT_EQ(replica_.hash(), diff.hash);
    EXPECT_TRUE(Feed({ProgressEvent(diff.to_revision, diff.hash)}).ok());
  }
  Mesh copy = replica_.ToMesh(), original = fake_.Snapshot();
  EXPECT_EQ(ComputeHash(copy), fake_.hash());
  Canonicalize(copy);
  Canonicalize(original);
  EXPECT_EQ(copy.vertices, original.vertices);
  EXPECT_EQ(copy.simplices, original.simplices);
  EXPECT_EQ(copy.subsegments, original.subsegments);
  EXPECT_EQ(copy.subfacets, original.subfacets);
}

// Snapshot and diffs of 3D meshes, in fragments, subfacets included.
TEST_F(MeshReplicaTest, FollowsAMeshOfSpace) {
  auto random = testing::MakeRandom();
  Mesh mesh = testing::MakeUpLabelledMesh(random, 40, 3, 3);
  const Mesh other = testing::MakeUpLabelledMesh(random, 50, 4, 3);
  ASSERT_TRUE(Feed(SnapshotEvents(mesh)).ok());
  EXPECT_EQ(replica_.subfacet_count(), 20u);
  ASSERT_TRUE(Feed(DiffEvents(mesh_data::DiffMeshes(mesh, other))).ok());
  EXPECT_EQ(replica_.subfacet_count(), 25u);
  Mesh copy = replica_.ToMesh();
  mesh = other;
  Canonicalize(copy);
  Canonicalize(mesh);
  EXPECT_TRUE(testing::Identical(copy, mesh));
}

TEST_F(MeshReplicaTest, SaysWhatAnEventDid) {
  const Events snapshot = SnapshotEvents(start_);
  for (std::size_t i = 0; i < snapshot.size(); ++i) {
    const auto change = replica_.Take(snapshot[i]);
    ASSERT_TRUE(change.ok());
    EXPECT_EQ(std::holds_alternative<MeshReplica::NewSnapshot>(*change), i + 1 == snapshot.size());
  }
  const auto change = replica_.Take(DiffEvents(diffs_[0], 1 << 20)[0]);
  ASSERT_TRUE(change.ok());
  ASSERT_TRUE(std::holds_alternative<MeshDiff>(*change));
  EXPECT_EQ(std::get<MeshDiff>(*change).to_revision, diffs_[0].to_revision);
}

// Every invalid stream of a table: after start and the first diff come its events, one of which
// must be refused. The replica keeps the last good mesh and accepts nothing more until a snapshot.
TEST_F(MeshReplicaTest, NoticesEveryLieAndRecoversBySnapshotOnly) {
  struct Lie {
    const char* name;
    absl::StatusCode code;
    std::function<Events()> events;
  };
  const auto changed = [](Events events, const std::function<void(v1::MeshDiff&)>& change) {
    change(*events[0].mutable_diff());
    return events;
  };
  const auto whole = [&](std::size_t i) { return DiffEvents(diffs_[i], 1 << 20); };
  const auto gap = absl::StatusCode::kFailedPrecondition;
  const auto damage = absl::StatusCode::kDataLoss;
  const std::vector<Lie> lies = {
      {"a diff is lost", gap, [&] { return whole(2); }},
      {"a diff comes twice", gap, [&] { return whole(0); }},
      {"a fragment is lost", damage,
       [&] {
         Events events = DiffEvents(diffs_[1], 50);
         events.erase(events.begin());
         return events;
       }},
      {"another diff begins inside one", gap,
       [&] {
         Events events = DiffEvents(diffs_[1], 50);
         events.resize(1);
         for (auto& e : DiffEvents(diffs_[2])) events.push_back(e);
         return events;
       }},
      {"a snapshot begins inside a diff", gap,
       [&] {
         Events events = DiffEvents(diffs_[1], 50);
         events.resize(1);
         events.push_back(SnapshotEvents(start_)[0]);
         return events;
       }},
      {"a diff begins inside a snapshot", gap,
       [&] {
         return Events{SnapshotEvents(start_)[0], DiffEvents(diffs_[1])[0]};
       }},
      {"a coordinate is damaged", damage,
       [&] {
         return changed(whole(1), [](v1::MeshDiff& d) {
           auto* x = d.mutable_added_vertices()->mutable_coordinates()->Mutable(0);
           *x = std::nextafter(*x, 1.0);
         });
       }},
      {"an owner is damaged", damage,
       [&] {
         return changed(whole(1),
                        [](v1::MeshDiff& d) { d.mutable_added_vertices()->set_owners(0, 99); });
       }},
      {"a removal is left out", damage,
       [&] { return changed(whole(1), [](v1::MeshDiff& d) { d.clear_removed_simplices(); }); }},
      {"an absent vertex is removed", damage,
       [&] { return changed(whole(1), [](v1::MeshDiff& d) { d.add_removed_vertices(5); }); }},
      {"the hash is another", damage,
       [&] {
         return changed(whole(1), [](v1::MeshDiff& d) { d.set_hash(MeshHash{1, 2}.ToHex()); });
       }},
      {"columns disagree", damage,
       [&] {
         return changed(whole(1), [](v1::MeshDiff& d) { d.mutable_added_vertices()->add_ids(3); });
       }},
      {"time runs backwards", gap,
       [&] {
         return changed(whole(1), [](v1::MeshDiff& d) { d.set_to_revision(d.from_revision()); });
       }},
      {"the columns are left out", gap,
       [&] { return changed(whole(1), [](v1::MeshDiff& d) { d.set_columns_omitted(true); }); }},
      {"progress tells of a lost revision", gap,
       [&] { return Events{ProgressEvent(diffs_[1].to_revision, diffs_[1].hash)}; }},
      {"progress tells of another mesh", damage,
       [&] {
         return Events{ProgressEvent(diffs_[0].to_revision, MeshHash{7, 7})};
       }},
  };
  for (const Lie& lie : lies) {
    SCOPED_TRACE(lie.name);
    replica_ = MeshReplica();
    ASSERT_TRUE(Feed(SnapshotEvents(start_)).ok());
    ASSERT_TRUE(Feed(DiffEvents(diffs_[0])).ok());
    const absl::Status status = Feed(lie.events());
    EXPECT_EQ(status.code(), lie.code) << status;
    EXPECT_EQ(replica_.state(), MeshReplica::State::kBroken);
    EXPECT_EQ(replica_.revision(), diffs_[0].to_revision);
    EXPECT_EQ(ComputeHash(replica_.ToMesh()), diffs_[0].hash);
    // Even the right diff is refused now.
    EXPECT_FALSE(Feed(whole(1)).ok());
    ASSERT_TRUE(Feed(SnapshotEvents(fake_.Snapshot())).ok());
    EXPECT_EQ(replica_.state(), MeshReplica::State::kLive);
    EXPECT_EQ(replica_.hash(), fake_.hash());
  }
}

TEST_F(MeshReplicaTest, ADamagedSnapshotIsRefused) {
  Events events = SnapshotEvents(start_, 1 << 20);
  events[0].mutable_snapshot()->mutable_vertices()->mutable_coordinates()->Set(0, 0.123);
  EXPECT_EQ(Feed(events).code(), absl::StatusCode::kDataLoss);
  EXPECT_FALSE(replica_.has_mesh());
}

TEST_F(MeshReplicaTest, WhatAStreamLeftUnfinishedIsForgotten) {
  ASSERT_TRUE(Feed(SnapshotEvents(start_)).ok());
  Events part = DiffEvents(diffs_[0], 50);
  part.pop_back();
  ASSERT_TRUE(Feed(part).ok());
  EXPECT_EQ(replica_.revision(), start_.revision);
  replica_.EndOfStream();
  EXPECT_EQ(replica_.state(), MeshReplica::State::kLive);
  ASSERT_TRUE(Feed(DiffEvents(diffs_[0])).ok());
  EXPECT_EQ(replica_.revision(), diffs_[0].to_revision);
}

TEST_F(MeshReplicaTest, AnEventFromTheFutureIsIgnored) {
  ASSERT_TRUE(Feed(SnapshotEvents(start_)).ok());
  EXPECT_TRUE(Feed({v1::WatchEvent()}).ok());
  EXPECT_EQ(replica_.state(), MeshReplica::State::kLive);
}

}  // namespace
}  // namespace dynmesh::client::mesh_replica_test
