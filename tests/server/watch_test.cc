// Watch over loopback, with fake meshes: following, lagging, cancelling, many at once.
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "core/mesh_data/region_filter.h"
#include "dynmesh/client/mesh_replica.h"
#include "proto/codec/grpc_status.h"
#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::watch_test {
namespace {

using WatchTest = ServerFixture;

TEST_F(WatchTest, AReplicaFollowsAWriter) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  const auto watch = client_->Watch("m", {}, nullptr);
  for (FeatureId id = 10; id < 60; ++id) ASSERT_TRUE(client_->Apply("m", {AddPoint(id)}).ok());
  ASSERT_TRUE(watch->WaitForRevision(51, kLong));
  watch->Read([&](const client::MeshReplica& r) {
    EXPECT_EQ(r.hash(), HeadOf().hash);
    EXPECT_EQ(ComputeHash(r.ToMesh()), HeadOf().hash);
  });
  EXPECT_EQ(watch->resyncs(), 0);
}

TEST_F(WatchTest, AnIdleWatcherHearsOfProgress) {
  StartWithMesh();
  struct Listener : client::WatchListener {
    void OnProgress(const client::MeshReplica&) override { progress.Put(0); }
    Mailbox<int> progress;
  } listener;
  client::WatchOptions options;
  options.progress_interval = absl::Milliseconds(100);
  const auto watch = client_->Watch("m", options, &listener);
  EXPECT_EQ(listener.progress.Take(), 0);
  EXPECT_EQ(listener.progress.Take(), 0);
}

TEST_F(WatchTest, WatchesRefuseBadStarts) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  const auto finish = [&](auto change) {
    v1::WatchRequest request;
    request.set_mesh("meshes/m");
    change(request);
    grpc::ClientContext context;
    const auto reader = stub_->Watch(&context, request);
    v1::WatchEvent event;
    EXPECT_FALSE(reader->Read(&event));
    return codec::FromGrpcStatus(reader->Finish());
  };
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.set_start_revision(2); })),
            codec::reason::kFutureRevision);
  EXPECT_EQ(ReasonOf(finish([](auto& r) {
              r.set_start_revision(1);
              r.set_start_hash(MeshHash{1, 1}.ToHex());
            })),
            codec::reason::kDiverged);
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.set_start_hash("xyz"); })), codec::reason::kBadRequest);
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.mutable_progress_interval()->set_seconds(-1); })),
            codec::reason::kBadRequest);
  EXPECT_EQ(ReasonOf(finish([](auto& r) {
              r.add_regions(7);
              r.set_start_revision(1);
            })),
            codec::reason::kBadRequest);
  for (const FeatureId none : {kNoFeature, kBoxFeature}) {
    EXPECT_EQ(ReasonOf(finish([&](auto& r) { r.add_regions(none); })), codec::reason::kBadRequest);
  }
  EXPECT_EQ(ReasonOf(finish([](auto& r) {
              for (FeatureId id = 1; id <= 10'001; ++id) r.add_regions(id);
            })),
            codec::reason::kBadRequest);
  EXPECT_EQ(ReasonOf(finish([](auto& r) { r.set_mesh("meshes/none"); })),
            codec::reason::kMeshNotFound);
}

Mesh Sorted(Mesh mesh) {
  Canonicalize(mesh);
  return mesh;
}

// Points 1 to 60, and polygons around some that come, change and go.
TEST_F(WatchTest, AWatchOfRegionsEndsEqualToAnExportOfThem) {
  StartWithMesh();
  EditBatch points;
  for (FeatureId id = 1; id <= 60; ++id) points.push_back(AddPoint(id));
  ASSERT_TRUE(client_->Apply("m", points).ok());
  const std::vector<FeatureId> regions = {501, 503};
  client::WatchOptions options;
  options.regions = {503, 501, 501};
  const auto watch = client_->Watch("m", options, nullptr);
  const auto ring = [](FeatureId from, FeatureId to) {
    std::vector<FeatureId> ids;
    for (FeatureId id = from; id < to; ++id) ids.push_back(id);
    return Rings{ids};
  };
  const std::vector<Edit> edits = {Edit::Add(Feature::Polygon(501, ring(1, 30))),
                                   Edit::Add(Feature::Polygon(502, ring(20, 50))),
                                   Edit::Add(Feature::Polygon(503, ring(25, 45))),
                                   Edit::Set(Feature::Polygon(501, ring(1, 10))),
                                   Edit::Set(Feature::Polygon(502, ring(1, 20))),
                                   Edit::Remove(503),
                                   Edit::Add(Feature::Polygon(503, ring(5, 40)))};
  for (const Edit& edit : edits) {
    const auto applied = client_->Apply("m", {edit});
    ASSERT_TRUE(applied.ok()) << Text(applied.status());
    ASSERT_TRUE(watch->WaitForRevision(applied->diff.to_revision, kLong));
    const auto part = client_->GetSnapshot("m", regions);
    ASSERT_TRUE(part.ok()) << Text(part.status());
    EXPECT_LT(part->simplex_count(), 58u);
    watch->Read([&](const client::MeshReplica& r) {
      mesh_data::RegionChoice choice;
      choice.in = regions;
      const Mesh inside = Sorted(mesh_data::OnlyInside(r.ToMesh(), choice)), got = Sorted(*part);
      EXPECT_EQ(inside.vertices, got.vertices);
      EXPECT_EQ(inside.simplices, got.simplices);
      EXPECT_EQ(inside.regions, got.regions);
      EXPECT_EQ(inside.region_sets, got.region_sets);
      EXPECT_EQ(inside.hash, got.hash);
      EXPECT_EQ(r.simplex_count(), got.simplex_count());
      EXPECT_EQ(r.vertex_count(), 60u);
    });
  }
  EXPECT_EQ(client_->GetSnapshot("m", regions)->simplex_count(), 37u);  // from 1 to 37
  EXPECT_EQ(client_->GetSnapshot("m", std::vector<FeatureId>{777})->vertices.size(), 0u);
  EXPECT_EQ(client_->GetSnapshot("m", std::vector<FeatureId>{0}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(watch->resyncs(), 0);
}

// A client that reads nothing leaves a few of these in the server.
TEST_F(WatchTest, MessagesAreSmallHoweverLargeTheMesh) {
  StartWithMesh();
  const auto many = [](FeatureId from) {
    EditBatch batch;
    for (FeatureId id = from; id < from + 5000; ++id) batch.push_back(AddPoint(id));
    return batch;
  };
  ASSERT_TRUE(client_->Apply("m", many(1)).ok());
  v1::WatchRequest request;
  request.set_mesh("meshes/m");
  grpc::ClientContext context;
  const auto reader = stub_->Watch(&context, request);
  v1::WatchEvent event;
  std::size_t largest = 0, sum = 0;
  const auto read_until = [&](auto is_last) {
    do {
      ASSERT_TRUE(reader->Read(&event));
      largest = std::max(largest, event.ByteSizeLong());
      sum += event.ByteSizeLong();
    } while (!is_last());
  };
  read_until([&] { return event.has_snapshot() && !event.snapshot().more(); });
  ASSERT_TRUE(client_->Apply("m", many(10'001)).ok());
  read_until([&] { return event.has_diff() && !event.diff().more(); });
  EXPECT_GT(sum, 3 * 70'000u);
  EXPECT_LT(largest, 70'000u);
  context.TryCancel();
}

// The watcher takes one message and then none while the writer makes hundreds of large
// revisions, far more than any buffer on the way holds.
TEST_F(WatchTest, AWatcherThatStopsReadingDoesNotSlowTheWriterAndEndsEqual) {
  ServerConfig config;
  config.history_bytes = 1 << 20;
  StartWithMesh(config);
  v1::WatchRequest request;
  request.set_mesh("meshes/m");
  grpc::ClientContext context;
  const auto reader = stub_->Watch(&context, request);
  client::MeshReplica replica;
  v1::WatchEvent event;
  ASSERT_TRUE(reader->Read(&event));
  ASSERT_TRUE(replica.Take(event).ok());

  EditBatch batch;
  for (FeatureId id = 1; id <= 2000; ++id) batch.push_back(AddPoint(id));
  EditBatch undo;
  for (FeatureId id = 1; id <= 2000; ++id) undo.push_back(Edit::Remove(id));
  client::EditParams params;
  params.omit_columns = true;
  std::uint64_t last = 0;
  for (int round = 0; round < 100; ++round) {
    ASSERT_TRUE(client_->Apply("m", batch, params).ok());
    const auto result = client_->Apply("m", undo, params);
    ASSERT_TRUE(result.ok());
    last = result->diff.to_revision;
  }
  const auto result = client_->Apply("m", batch, params);
  ASSERT_TRUE(result.ok());
  ++last;
  // It never read while the writer wrote, and yet the writer is done.
  while (replica.revision() < last) {
    ASSERT_TRUE(reader->Read(&event));
    const auto change = replica.Take(event);
    ASSERT_TRUE(change.ok()) << Text(change.status());
  }
  EXPECT_EQ(replica.hash(), result->diff.hash);
  context.TryCancel();
  reader->Finish();
}

int ThreadsOfThisProcess() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("Threads:", 0) == 0) return std::stoi(line.substr(8));
  }
  return -1;
}

TEST_F(WatchTest, TwoHundredWatchersEndWithTheServersHash) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  std::vector<std::unique_ptr<client::WatchSession>> watches;
  for (int i = 0; i < 200; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
  for (FeatureId id = 10; id < 110; ++id) ASSERT_TRUE(client_->Apply("m", {AddPoint(id)}).ok());
  for (const auto& watch : watches) {
    ASSERT_TRUE(watch->WaitForRevision(101, kLong));
    watch->Read([&](const client::MeshReplica& r) { EXPECT_EQ(r.hash(), HeadOf().hash); });
    EXPECT_EQ(watch->resyncs(), 0);
  }
}

TEST_F(WatchTest, AThousandIdleWatchersCostNoThreads) {
  ServerConfig config;
  config.max_streams_per_client = 2'000;
  StartWithMesh(config);
  const auto first = client_->Watch("m", {}, nullptr);
  ASSERT_TRUE(first->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
  const int before = ThreadsOfThisProcess();
  ASSERT_GT(before, 0);
  std::vector<std::unique_ptr<client::WatchSession>> watches;
  for (int i = 0; i < 1000; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
  for (const auto& watch : watches) {
    ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
  }
  EXPECT_EQ(client_->GetStats("m")->mesh->watchers, 1001u);
  // Server and client together; gRPC may start a few of its own, whatever the number.
  EXPECT_LT(ThreadsOfThisProcess(), before + 20);
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  for (const auto& watch : watches) ASSERT_TRUE(watch->WaitForRevision(1, kLong));
}

TEST_F(WatchTest, WatchersThatLeaveAreForgotten) {
  StartWithMesh();
  {
    std::vector<std::unique_ptr<client::WatchSession>> watches;
    for (int i = 0; i < 20; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
    for (const auto& watch : watches) {
      ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
    }
  }
  // The server notices it a little later: the places are released first, the calls then.
  test::WaitUntil("the end of the watches", [&] { return client_->GetStats()->watchers == 0; });
  EXPECT_EQ(Host()->hub()->size(), 0u);
}

TEST_F(WatchTest, DeletingAMeshEndsItsWatchesAndEdits) {
  StartWithMesh();
  const auto watch = client_->Watch("m", {}, nullptr);
  ASSERT_TRUE(watch->WaitFor([](const auto& r) { return r.has_mesh(); }, kLong));
  const auto edits = client_->OpenEdits("m");
  ASSERT_TRUE(edits->Send({AddPoint(1)}).ok());
  ASSERT_TRUE(edits->Receive()->result.ok());
  ASSERT_TRUE(client_->DeleteMesh("m").ok());
  EXPECT_FALSE(watch->WaitForRevision(99, kLong));
  EXPECT_EQ(ReasonOf(*watch->ended()), codec::reason::kMeshDeleted);
  ASSERT_TRUE(edits->Send({AddPoint(2)}).ok());
  EXPECT_EQ(ReasonOf(edits->Receive()->result.status()), codec::reason::kMeshDeleted);
  // The name is free again, for another mesh.
  EXPECT_EQ(client_->CreateMesh("m", {})->revision, 0u);
}

TEST_F(WatchTest, AWatcherOfAServerThatLostItsMeshesIsToldSoAndKeepsWhatItHas) {
  StartWithMesh();
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1)}).ok());
  const MeshHash hash = HeadOf().hash;
  client::WatchOptions options;
  options.first_pause = absl::Milliseconds(5);
  options.longest_pause = absl::Milliseconds(50);
  options.max_attempts = 10'000;
  const auto watch = client_->Watch("m", options, nullptr);
  ASSERT_TRUE(watch->WaitForRevision(1, kLong));
  ServerConfig config;
  config.listen = server_->address();
  server_.reset();
  const auto next =
      Server::Start(config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); });
  ASSERT_TRUE(next.ok()) << Text(next.status());
  EXPECT_FALSE(watch->WaitForRevision(2, kLong));
  ASSERT_TRUE(watch->ended().has_value());
  EXPECT_EQ(ReasonOf(*watch->ended()), codec::reason::kMeshNotFound);
  watch->Read([&](const client::MeshReplica& r) { EXPECT_EQ(r.hash(), hash); });
}

}  // namespace
}  // namespace dynmesh::server::watch_test
