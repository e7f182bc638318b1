// dynmeshd with a data folder, killed at random moments: under load, while it writes snapshots,
// while it starts. After every start each mesh has the acknowledged batches, and possibly all of
// the one in progress; the retry shows which. Watchers resume through all of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/client/edit_session.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/client/watch_session.h"
#include "dynmesh/dynamic_mesh.h"
#include "proto/codec/status_codec.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/killed_clients.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh {
namespace {
using client::MeshClient;
using test::Daemon;
using test::Editor;
using test::NewSeed;
using test::Streamer;
using test::TempFolder;

class KillTest : public ::testing::Test {
 protected:
  std::vector<std::string> Flags() const {
    return {"--data-dir", folder_.path() + "/data", "--compact-bytes", "2000"};
  }
  // The same after every start, so that connected clients reconnect.
  std::string Listen() const { return "unix:" + folder_.path() + "/socket"; }
  std::unique_ptr<MeshClient> Connect() const {
    client::ClientOptions options;
    options.own_connection = true;
    return MeshClient::Connect(Listen(), options);
  }
  // The watcher gets there, and has the server's mesh then.
  static void ExpectWatched(client::WatchSession& watch, std::uint64_t revision,
                            MeshClient& client) {
    ASSERT_TRUE(watch.WaitForRevision(revision, absl::Seconds(60)))
        << (watch.ended().has_value() ? *watch.ended() : absl::OkStatus());
    auto theirs = client.GetSnapshot("w");
    ASSERT_TRUE(theirs.ok()) << theirs.status();
    ASSERT_EQ(theirs->revision, revision);
    watch.Read([&](const client::MeshReplica& replica) {
      ASSERT_EQ(replica.revision(), revision);
      Mesh ours = replica.ToMesh();
      Canonicalize(ours);
      Canonicalize(*theirs);
      EXPECT_EQ(ours.hash, theirs->hash);
      EXPECT_EQ(ours.vertices, theirs->vertices);
      EXPECT_EQ(ours.simplices, theirs->simplices);
    });
  }

  TempFolder folder_;
  Daemon daemon_{folder_.path()};
};

TEST_F(KillTest, AtRandomMomentsLosesNothingThatWasAcknowledged) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  const int kills = std::getenv("DYNMESH_NIGHTLY") != nullptr ? 200 : 10;
  std::mt19937_64 random(seed);
  const auto kill_within = [&](int microseconds) {
    std::this_thread::sleep_for(std::chrono::microseconds(random() % microseconds));
    daemon_.End(SIGKILL);
  };
  Editor editors[] = {{"a", seed + 1}, {"b", seed + 2}, {"c", seed + 3}, {"w", seed + 4, true}};
  const Editor& watched = editors[3];
  std::unique_ptr<MeshClient> watcher;
  std::unique_ptr<client::WatchSession> watch;
  for (int i = 0; i < kills; ++i) {
    SCOPED_TRACE(absl::StrCat("start ", i));
    if (i % 3 == 2) {  // in the middle of starting again
      ASSERT_TRUE(daemon_.Spawn(Flags(), Listen().c_str()));
      kill_within(60'000);
    }
    ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
    const auto client = Connect();
    if (watch == nullptr) {
      ASSERT_TRUE(editors[3].Create(*client));
      watcher = Connect();
      client::WatchOptions options;
      options.max_attempts = 1'000;
      options.longest_pause = absl::Milliseconds(100);
      watch = watcher->Watch("w", options, nullptr);
    }
    for (Editor& editor : editors) {
      editor.Check(*client);
      ASSERT_FALSE(HasFailure()) << daemon_.Log();
    }
    ExpectWatched(*watch, watched.revision(), *client);
    ASSERT_FALSE(HasFailure()) << daemon_.Log();
    std::vector<std::thread> threads;
    for (Editor& editor : editors) {
      threads.emplace_back([&] { editor.Work(*Connect()); });
    }
    kill_within(300'000);
    for (std::thread& thread : threads) thread.join();
    ASSERT_FALSE(HasFailure());
  }
  std::uint64_t acknowledged = 0;
  for (const Editor& editor : editors) acknowledged += editor.acknowledged();
  std::printf("%llu batches acknowledged; the watcher came back %d times, %d of them as new\n",
              static_cast<unsigned long long>(acknowledged), watch->reconnects(), watch->resyncs());
  EXPECT_GT(acknowledged, static_cast<std::uint64_t>(10 * kills));
  EXPECT_GE(watch->reconnects(), kills - 1);
  EXPECT_TRUE(absl::StrContains(daemon_.Log(), "compacted"));
}

// Many batches in progress, applied ahead of the disk, written together.
TEST_F(KillTest, InTheMiddleOfAStreamLosesNothingThatWasAcknowledged) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  const int kills = std::getenv("DYNMESH_NIGHTLY") != nullptr ? 200 : 10;
  std::mt19937_64 random(seed);
  Streamer streamers[] = {{"s", seed + 1}, {"t", seed + 2}};
  for (int i = 0; i < kills; ++i) {
    SCOPED_TRACE(absl::StrCat("start ", i));
    ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
    const auto client = Connect();
    for (const char* id : {"s", "t"}) {
      if (i == 0) {
        ASSERT_TRUE(client->CreateMesh(id, MeshOptions()).ok());
      }
    }
    std::vector<std::thread> threads;
    for (Streamer& streamer : streamers) {
      streamer.Check(*client);
      ASSERT_FALSE(HasFailure()) << daemon_.Log();
    }
    for (Streamer& streamer : streamers) {
      threads.emplace_back([&] { streamer.Work(*Connect()); });
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 300'000));
    daemon_.End(SIGKILL);
    for (std::thread& thread : threads) thread.join();
    ASSERT_FALSE(HasFailure());
  }
  std::uint64_t acknowledged = 0, unacknowledged = 0;
  for (const Streamer& streamer : streamers) {
    acknowledged += streamer.acknowledged();
    unacknowledged += streamer.unacknowledged();
  }
  std::printf("%llu batches acknowledged, %llu more were written down\n",
              static_cast<unsigned long long>(acknowledged),
              static_cast<unsigned long long>(unacknowledged));
  EXPECT_GT(acknowledged, static_cast<std::uint64_t>(20 * kills));
}

// A snapshot of several transactions is in progress, or about to be, or done.
TEST_F(KillTest, InTheMiddleOfALargeSnapshotLosesNothing) {
  std::mt19937_64 random(NewSeed());
  constexpr FeatureId kPoints = 100'000;
  EditBatch batch;
  for (FeatureId id = 1; id <= kPoints; ++id) {
    batch.push_back(Edit::Add(Feature::Point(id, (0.5 + static_cast<double>(id % 317)) / 320,
                                             (0.5 + static_cast<double>(id / 317)) / 320)));
  }
  const int kills = std::getenv("DYNMESH_NIGHTLY") != nullptr ? 8 : 2;
  for (int i = 0; i < kills; ++i) {
    ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
    const std::string id = absl::StrCat("m", i);
    ASSERT_TRUE(Connect()->CreateMesh(id, MeshOptions()).ok());
    client::EditParams params;
    params.omit_columns = true;
    // A mesh's first batch does not cause a snapshot.
    ASSERT_TRUE(Connect()->Apply(id, {batch.front()}, params).ok());
    EditBatch rest(batch.begin() + 1, batch.end());
    const auto made = Connect()->Apply(id, rest, params);
    ASSERT_TRUE(made.ok()) << made.status();
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 300'000));
    daemon_.End(SIGKILL);
    ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
    const auto found = Connect()->GetFeatures(id);
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->revision, 2u);
    EXPECT_EQ(found->hash, made->diff.hash);
    EXPECT_EQ(found->features.size(), kPoints);
    EXPECT_EQ(Connect()->GetMesh(id)->hash, made->diff.hash);
    ASSERT_TRUE(Connect()->DeleteMesh(id).ok());
    daemon_.End(SIGKILL);
  }
}

TEST_F(KillTest, ASecondServerDoesNotTakeTheFolder) {
  ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
  TempFolder other;
  Daemon second(other.path());
  EXPECT_FALSE(second.Start(Flags()));
  EXPECT_TRUE(absl::StrContains(second.Log(), "is in use by process")) << second.Log();
}

TEST_F(KillTest, AnOrderlyEndIsRecoveredToo) {
  ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
  ASSERT_TRUE(Connect()->CreateMesh("m", MeshOptions()).ok());
  const auto made = Connect()->Apply(
      "m", {Edit::Add(Feature::Point(1, 0.25, 0.5)),
            Edit::Add(Feature::Size(2, {0.5, 0.5, 0}, {SizeShape::kDisc, 0.1, 0.2, {}})),
            Edit::Add(Feature::SizeCapsule(5, {{0.1, 0.1}, {0.9, 0.2}, {0.9, 0.9}}, 0.02, 0.05)),
            Edit::Add(Feature::Point(3, 0.75, 0.5)), Edit::Add(Feature::Segment(4, 1, 3))});
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(daemon_.End(SIGTERM), 0);
  ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
  const auto info = Connect()->GetMesh("m");
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->revision, 1u);
  EXPECT_EQ(info->hash, made->diff.hash);
  EXPECT_EQ(Connect()->GetStats("m")->mesh->stats.features, 5u);
}

}  // namespace
}  // namespace dynmesh
