// dynmeshd with its journal in PostgreSQL: killed, with its database killed, and beside another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/killed_clients.h"
#include "tests/server/journal/postgres_server.h"
#include "tests/support/label_script.h"
#include "tests/support/nightly.h"
#include "tests/support/temp_folder.h"

namespace dynmesh {
namespace {

using client::MeshClient;
using server::PostgresServer;
using test::Daemon;
using test::ReasonOf;
using test::Streamer;
using test::TempFolder;

class PostgresDaemonTest : public ::testing::Test {
 protected:
  std::vector<std::string> Flags() const {
    return {"--journal", database_.Url("postgres"), "--compact-bytes", "2000"};
  }
  std::string Listen() const { return "unix:" + folder_.path() + "/socket"; }
  std::unique_ptr<MeshClient> Connect(const std::string& address = "") const {
    client::ClientOptions options;
    options.own_connection = true;
    return MeshClient::Connect(address.empty() ? Listen() : address, options);
  }
  static EditBatch Point(FeatureId id) {
    return {Edit::Add(Feature::Point(id, 0.01 * static_cast<double>(id), 0.5))};
  }

  PostgresServer database_;
  TempFolder folder_;
  Daemon daemon_{folder_.path()};
};

TEST_F(PostgresDaemonTest, KilledWithOrWithoutItsDatabaseItLosesNothing) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  const int kills = test::IsNightly() ? 150 : 9;
  std::mt19937_64 random(seed);
  Streamer streamers[] = {{"s", seed + 1}, {"t", seed + 2}};
  ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
  for (const char* id : {"s", "t"}) ASSERT_TRUE(Connect()->CreateMesh(id, MeshOptions()).ok());
  for (int i = 0; i < kills; ++i) {
    SCOPED_TRACE(absl::StrCat("kill ", i));
    const bool kills_daemon = i % 3 != 1, kills_database = i % 3 != 0;
    const auto client = Connect();
    for (Streamer& streamer : streamers) {
      streamer.Check(*client);
      ASSERT_FALSE(HasFailure()) << daemon_.Log();
    }
    std::vector<std::thread> threads;
    for (Streamer& streamer : streamers) {
      threads.emplace_back([&] { streamer.Work(*Connect()); });
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 300'000));
    if (kills_database) database_.Kill();
    if (kills_daemon) daemon_.End(SIGKILL);
    if (kills_database) database_.Start();
    // With the daemon alive a stream may outlive its database: appends are found and go on.
    if (!kills_daemon) daemon_.End(SIGKILL);
    for (std::thread& thread : threads) thread.join();
    ASSERT_FALSE(HasFailure());
    ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
  }
  std::uint64_t acknowledged = 0;
  for (const Streamer& streamer : streamers) acknowledged += streamer.acknowledged();
  std::printf("%llu batches acknowledged\n", static_cast<unsigned long long>(acknowledged));
  EXPECT_GT(acknowledged, static_cast<std::uint64_t>(10 * kills));
  EXPECT_TRUE(absl::StrContains(daemon_.Log(), "compacted"));
}

// Entries, snapshots and the past have the labels of their features.
TEST_F(PostgresDaemonTest, LabelsComeBack) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  test::LabelledScript script(test::ScriptGenerator(test::Distribution::kPolygons, 20, seed),
                              seed + 1);
  ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
  ASSERT_TRUE(Connect()->CreateMesh("m", MeshOptions()).ok());
  std::vector<std::vector<Feature>> past = {{}};
  for (int step = 0; step < 60; ++step) {
    const auto client = Connect();
    const EditBatch batch = script.Next(past.back());
    const auto applied = client->Apply("m", batch);
    if (applied.ok() && !batch.empty()) past.push_back(client->GetFeatures("m")->features);
    if (step % 20 != 19) continue;
    daemon_.End(SIGKILL);
    ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
    const auto again = Connect();
    for (std::uint64_t r = past.size() - 1; r > 0; --r) {
      const auto found = again->GetFeatures("m", r);
      if (absl::IsOutOfRange(found.status())) break;  // compacted
      ASSERT_TRUE(found.ok()) << found.status();
      EXPECT_EQ(found->features, past[r]) << "revision " << r;
    }
    const std::uint64_t before = past.size() - 2;
    ASSERT_TRUE(again->RevertTo("m", before).ok());
    past.push_back(past[before]);
    EXPECT_EQ(again->GetFeatures("m")->features, past.back());
    LabelColumn labels;
    for (const Feature& f : past.back()) {
      if (f.label) labels.push_back({f.id, *f.label});
    }
    EXPECT_EQ(again->GetSnapshot("m")->labels, labels);
  }
  EXPECT_TRUE(absl::StrContains(daemon_.Log(), "compacted"));
}

TEST_F(PostgresDaemonTest, ASecondServerTakesTheMeshesAndTheFirstIsFenced) {
  ASSERT_TRUE(daemon_.Start(Flags(), Listen().c_str())) << daemon_.Log();
  const auto first = Connect();
  ASSERT_TRUE(first->CreateMesh("m", MeshOptions()).ok());
  ASSERT_TRUE(first->Apply("m", Point(1)).ok());
  TempFolder other;
  Daemon daemon(other.path());
  ASSERT_TRUE(daemon.Start(Flags())) << daemon.Log();
  const auto second = Connect(daemon.address());
  for (int i = 0; i < 2; ++i) {
    const absl::Status refused = first->Apply("m", Point(2)).status();
    EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
    EXPECT_EQ(ReasonOf(refused), codec::reason::kNotOwner) << refused;
  }
  EXPECT_EQ(ReasonOf(first->GetMesh("m").status()), codec::reason::kNotOwner);
  const auto made = second->Apply("m", Point(3));
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->diff.to_revision, 2u);
  EXPECT_TRUE(absl::StrContains(daemon_.Log(), "mesh_disowned")) << daemon_.Log();
}

TEST_F(PostgresDaemonTest, OneOfBothJournalsIsGiven) {
  std::vector<std::string> flags = Flags();
  flags.insert(flags.end(), {"--data-dir", folder_.path() + "/data"});
  EXPECT_FALSE(daemon_.Start(flags));
  EXPECT_EQ(daemon_.exit_code(), 2);
  EXPECT_FALSE(daemon_.Start({"--node-address", "127.0.0.1"})) << "there is nothing to share";
  EXPECT_EQ(daemon_.exit_code(), 2);
  EXPECT_FALSE(daemon_.Start({"--journal", "mysql://x"}));
  EXPECT_EQ(daemon_.exit_code(), 2);
  EXPECT_TRUE(absl::StrContains(daemon_.Log(), "postgresql://")) << daemon_.Log();
}

}  // namespace
}  // namespace dynmesh
