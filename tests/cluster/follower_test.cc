// Nodes that follow the meshes of others: what they answer, what a false journal does to them, and
// meshes that move to them in a drain or after a kill. Leases are long, or their end is waited for.
//
// DYNMESH_CLUSTER_DRAINS: how many drains; default: a few. The pauses of writers are printed, not
// judged.
#include <grpcpp/grpcpp.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/journal_codec.h"
#include "server/journal/row_sum.h"
#include "tests/cluster/writer.h"
#include "tests/e2e/killed_clients.h"
#include "tests/server/http/http_get.h"

namespace dynmesh::test {
namespace {

// When each revision came.
class Arrivals final : public client::WatchListener {
 public:
  void OnDiff(const client::MeshReplica&, const MeshDiff& diff) override {
    const std::lock_guard lock(mutex_);
    for (std::uint64_t r = diff.from_revision + 1; r <= diff.to_revision; ++r)
      times_[r] = Clock::now();
  }
  // Seconds after `told`, of the revisions that came one by one.
  std::vector<double> After(const std::map<std::uint64_t, Clock::time_point>& told) const {
    const std::lock_guard lock(mutex_);
    std::vector<double> seconds;
    for (const auto& [revision, time] : told) {
      const auto it = times_.find(revision);
      if (it == times_.end()) continue;
      seconds.push_back(std::max(0.0, std::chrono::duration<double>(it->second - time).count()));
    }
    return seconds;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint64_t, Clock::time_point> times_;
};

class FollowerTest : public WriterTest {
 protected:
  explicit FollowerTest(const std::string& lease = "3600") : WriterTest(lease) {
    more_ = {"--metrics", "127.0.0.1:0"};
  }

  std::unique_ptr<MeshClient> ConnectTo(const std::string& address, bool from_followers) const {
    client::ClientOptions options;
    options.own_connection = true;
    options.from_followers = from_followers;
    return MeshClient::Connect(address, options);
  }
  const std::string& AddressOf(int node) const {
    return nodes_[static_cast<std::size_t>(node)]->address;
  }
  // The figure of that name and labels at the node; empty: there is none.
  static std::string Figure(const Node& node, const std::string& name) {
    const std::string log = node.daemon.Log();
    const std::string mark = "event=metrics_listen address=";
    const std::size_t begin = log.rfind(mark) + mark.size();
    const std::string address = log.substr(begin, log.find_first_of(" \n", begin) - begin);
    const std::string text =
        server::SendHttp(address, "GET /metrics HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    for (absl::string_view line : absl::StrSplit(text, '\n')) {
      if (absl::ConsumePrefix(&line, name + " ")) return std::string(line);
    }
    return "";
  }
  static bool Follows(const Node& node, const std::string& mesh) {
    return Figure(node, "dynmesh_mesh_role{mesh=\"" + mesh + "\",role=\"follower\"}") == "1";
  }
  // The addresses of the nodes that follow the mesh, by themselves and by the journal; waits for
  // one.
  std::vector<std::string> FollowersOf(const std::string& mesh) {
    std::vector<std::string> found;
    WaitUntil("a follower of " + mesh, [&] {
      for (const auto& node : nodes_) {
        const std::string told =
            Sql("SELECT count(*) FROM dynmesh.followers AS f JOIN dynmesh.nodes AS n ON n.id = "
                "f.node JOIN dynmesh.meshes AS m ON m.key = f.mesh WHERE m.id = '" +
                mesh + "' AND n.address = '" + node->address + "'");
        if (told == "1" && Follows(*node, mesh)) found.push_back(node->address);
      }
      return !found.empty();
    });
    return found;
  }
  // Replaces the hash in the entry of that revision of the only mesh.
  void FalsifyHash(std::uint64_t revision) {
    std::int64_t key = 0;
    ASSERT_TRUE(absl::SimpleAtoi(Sql("SELECT key FROM dynmesh.meshes"), &key));
    const std::string where = absl::StrCat(" WHERE revision = ", revision);
    const std::string data =
        absl::HexStringToBytes(Sql("SELECT encode(data, 'hex') FROM dynmesh.entries" + where));
    const auto entry = codec::DecodeJournalEntry(data, 2);
    ASSERT_TRUE(entry.ok()) << entry.status();
    MeshHash other = entry->hash;
    other.lo ^= 1;
    const std::string false_data = codec::EncodeJournalEntry(entry->edits, other, 2);
    const std::int64_t sum =
        server::RowSumOf(key, static_cast<std::int64_t>(revision), absl::string_view(false_data));
    Sql(absl::StrCat("UPDATE dynmesh.entries SET data = '\\x", absl::BytesToHexString(false_data),
                     "', checksum = ", sum, where));
  }
};

TEST_F(FollowerTest, ReadsOfAFollowerEqualTheOwners) {
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  StartNodes(3, more_);
  const auto writer = ConnectTo(AddressOf(0), false);
  ASSERT_TRUE(writer->CreateMesh("m", MeshOptions()).ok());
  // Only those nodes are known: what they do not answer is asked of the owner, which they name.
  Arrivals arrivals[2];
  std::map<std::uint64_t, Clock::time_point> told;
  std::vector<std::unique_ptr<MeshClient>> readers;
  std::vector<std::unique_ptr<client::WatchSession>> watches;  // end before what they use
  for (const int node : {1, 2}) {
    readers.push_back(ConnectTo(AddressOf(node), true));
    ASSERT_TRUE(readers.back()->GetSnapshot("m").ok());
    WaitUntil("a follower", [&] {
      EXPECT_TRUE(readers.back()->GetSnapshot("m").ok());
      return Follows(*nodes_[static_cast<std::size_t>(node)], "m");
    });
    watches.push_back(readers.back()->Watch("m", {}, &arrivals[node - 1]));
  }
  std::vector<FeatureId> there;
  std::uint64_t head = 0;
  std::uniform_real_distribution<double> place(0.02, 0.98);
  for (FeatureId id = 1; head < 200; ++id) {
    EditBatch batch = {Edit::Add(Feature::Point(id, place(random), place(random)))};
    if (there.size() > 30) {
      const std::size_t gone = random() % there.size();
      batch.push_back(Edit::Remove(there[gone]));
      there.erase(there.begin() + static_cast<std::ptrdiff_t>(gone));
    }
    const auto applied = writer->Apply("m", batch);
    if (!applied.ok()) {
      ASSERT_TRUE(absl::IsFailedPrecondition(applied.status())) << applied.status();
      continue;  // too close to another one
    }
    there.push_back(id);
    head = applied->diff.to_revision;
    told[head] = Clock::now();
  }
  const auto owners = writer->GetSnapshot("m");
  ASSERT_TRUE(owners.ok()) << owners.status();
  const std::vector<double> points = {0.3, 0.4, 0.71, 0.2, 0.5, 0.9};
  const auto located = writer->Locate("m", 2, points);
  ASSERT_TRUE(located.ok()) << located.status();
  for (std::size_t i = 0; i < watches.size(); ++i) {
    SCOPED_TRACE(absl::StrCat("node ", i + 1));
    ASSERT_TRUE(watches[i]->WaitForRevision(head, absl::Minutes(1)));
    watches[i]->Read([&](const client::MeshReplica& replica) {
      EXPECT_EQ(replica.revision(), head);
      EXPECT_EQ(replica.hash(), owners->hash);
    });
    EXPECT_EQ(watches[i]->reconnects(), 0);
    const Node& node = *nodes_[i + 1];
    EXPECT_EQ(Figure(node, "dynmesh_follower_watchers{mesh=\"m\"}"), "1");
    EXPECT_EQ(Figure(node, "dynmesh_follower_revision{mesh=\"m\"}"), absl::StrCat(head));
    EXPECT_EQ(Figure(node, "dynmesh_follower_mismatches_total"), "0");
    const auto snapshot = readers[i]->GetSnapshot("m");
    ASSERT_TRUE(snapshot.ok()) << snapshot.status();
    EXPECT_EQ(snapshot->revision, head);
    EXPECT_EQ(snapshot->hash, owners->hash);
    const auto found = readers[i]->Locate("m", 2, points);
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->simplices, located->simplices);
    EXPECT_EQ(readers[i]->GetFeatures("m")->features, writer->GetFeatures("m")->features);
  }
  EXPECT_EQ(OwnerOf("m"), AddressOf(0));
  std::vector<double> lags = arrivals[0].After(told);
  for (const double lag : arrivals[1].After(told)) lags.push_back(lag);
  std::printf("{\"revisions\": %zu, \"p50_lag_seconds\": %.4f, \"p99_lag_seconds\": %.4f}\n",
              lags.size(), Quantile(lags, 0.5), Quantile(lags, 0.99));
}

TEST_F(FollowerTest, ANodeThatFollowsAnswersReadsThatMayBeOldOnly) {
  StartNodes(2, more_);
  const auto writer = ConnectTo(AddressOf(0), false);
  ASSERT_TRUE(writer->CreateMesh("m", MeshOptions()).ok());
  ASSERT_TRUE(writer->Apply("m", {Edit::Add(Feature::Point(1, 0.3, 0.3))}).ok());
  ASSERT_TRUE(ConnectTo(AddressOf(1), true)->GetSnapshot("m").ok());
  WaitUntil("a follower", [&] { return Follows(*nodes_[1], "m"); });
  const auto stub = v1::MeshService::NewStub(
      grpc::CreateChannel(AddressOf(1), grpc::InsecureChannelCredentials()));
  v1::SnapshotChunk chunk;
  const auto read = [&](std::optional<std::uint64_t> min_revision) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kPatience);
    v1::GetSnapshotRequest request;
    request.set_mesh("meshes/m");
    if (min_revision.has_value()) request.set_min_revision(*min_revision);
    const auto reader = stub->GetSnapshot(&context, request);
    while (reader->Read(&chunk)) {
    }
    return ReasonOf(codec::FromGrpcStatus(reader->Finish()));
  };
  EXPECT_EQ(read(0), "");
  EXPECT_EQ(read(1), "");
  EXPECT_EQ(chunk.revision(), 1u);
  EXPECT_EQ(read(std::nullopt), codec::reason::kNotOwner);
  EXPECT_EQ(read(2), codec::reason::kNotOwner);
}

TEST_F(FollowerTest, AFalseHashInTheJournalDropsTheReplicaAndIsTold) {
  StartNodes(2, more_);
  const auto writer = ConnectTo(AddressOf(0), false);
  const auto reader = ConnectTo(AddressOf(1), true);
  ASSERT_TRUE(writer->CreateMesh("m", MeshOptions()).ok());
  const auto apply = [&writer](FeatureId id) {
    const double at = 0.1 * static_cast<double>(id);
    return writer->Apply("m", {Edit::Add(Feature::Point(id, at, 0.7 - 0.5 * at))});
  };
  for (FeatureId id = 1; id <= 3; ++id) ASSERT_TRUE(apply(id).ok());
  ASSERT_TRUE(reader->GetSnapshot("m").ok());
  Node& node = *nodes_[1];
  WaitUntil("a follower",
            [&] { return Figure(node, "dynmesh_follower_revision{mesh=\"m\"}") == "3"; });
  node.daemon.Signal(SIGSTOP);
  ASSERT_TRUE(apply(4).ok());
  FalsifyHash(4);
  node.daemon.Signal(SIGCONT);
  // Read again from the beginning, it differs again: then it is not followed any more.
  WaitUntil("two mismatches", [&] {
    EXPECT_TRUE(reader->GetSnapshot("m").ok()) << "the owner answers";
    return Figure(node, "dynmesh_follower_mismatches_total") == "2";
  });
  EXPECT_FALSE(Follows(node, "m"));
  const std::string log = node.daemon.Log();
  EXPECT_NE(log.find("event=follower_mismatch mesh=m error=\"revision 4 "), std::string::npos)
      << log;
  ASSERT_TRUE(apply(5).ok());
  EXPECT_EQ(reader->GetSnapshot("m")->revision, 5u);
  EXPECT_EQ(Figure(node, "dynmesh_follower_mismatches_total"), "2");
}

TEST_F(FollowerTest, ADrainHandsMeshesOverAndNoWriterGetsAnError) {
  int drains = 3;
  if (const char* const given = std::getenv("DYNMESH_CLUSTER_DRAINS")) {
    ASSERT_TRUE(absl::SimpleAtoi(given, &drains));
  }
  StartNodes(3, more_);
  ASSERT_FALSE(HasFatalFailure());
  Writer writer("m", Connect());
  writer.Start();
  ASSERT_FALSE(HasFatalFailure());
  const auto watch = Connect()->Watch("m", {}, nullptr);
  std::vector<double> pauses;
  for (int i = 0; i < drains; ++i) {
    SCOPED_TRACE(absl::StrCat("drain ", i));
    const std::vector<std::string> next = FollowersOf("m");
    Node& owner = At(OwnerOf("m"));
    const Clock::time_point begun = Clock::now();
    const std::uint64_t before = writer.acknowledged();
    EXPECT_EQ(owner.daemon.End(SIGTERM), 0) << owner.daemon.Log();
    WaitUntil("batches", [&] { return writer.acknowledged() > before + 20; });
    EXPECT_EQ(std::count(next.begin(), next.end(), OwnerOf("m")), 1) << OwnerOf("m");
    pauses.push_back(writer.LongestPause(begun));
    Restart(owner);
    ASSERT_FALSE(HasFatalFailure());
  }
  writer.Stop();
  Judge(writer);
  EXPECT_EQ(writer.errors(), 0u);
  const std::uint64_t head = writer.acknowledged();
  EXPECT_TRUE(watch->WaitForRevision(head, absl::Minutes(1)));
  EXPECT_EQ(watch->resyncs(), 0);
  std::uint64_t takeovers = 0;
  for (const auto& node : nodes_) {
    const std::string log = node->daemon.Log();
    for (std::size_t at = 0; (at = log.find("event=taken_over", at)) != std::string::npos; ++at) {
      ++takeovers;
    }
  }
  EXPECT_EQ(takeovers, static_cast<std::uint64_t>(drains)) << "each found the mesh warm";
  std::printf(
      "{\"drains\": %d, \"p50_seconds\": %.3f, \"p99_seconds\": %.3f, \"max_seconds\": %.3f}\n",
      drains, Quantile(pauses, 0.5), Quantile(pauses, 0.99), Quantile(pauses, 1));
}

class KilledOwnerTest : public FollowerTest {
 protected:
  KilledOwnerTest() : FollowerTest("1") {}
};

TEST_F(KilledOwnerTest, AFollowerTakesTheMeshOverAndItsWatchesGoOn) {
  StartNodes(3, more_);
  ASSERT_FALSE(HasFatalFailure());
  Writer writer("m", Connect());
  writer.Start();
  ASSERT_FALSE(HasFatalFailure());
  Node& next = At(FollowersOf("m").front());
  const auto reader = ConnectTo(next.address, true);
  const auto watch = reader->Watch("m", {}, nullptr);
  ASSERT_TRUE(watch->WaitForRevision(1, absl::Minutes(1)));
  ASSERT_EQ(Figure(next, "dynmesh_follower_watchers{mesh=\"m\"}"), "1");
  At(OwnerOf("m")).daemon.End(SIGKILL);
  WaitUntil("the take-over", [&] { return OwnerOf("m") == next.address; });
  const std::uint64_t at = writer.acknowledged();
  WaitUntil("batches", [&] { return writer.acknowledged() > at + 20; });
  writer.Stop();
  EXPECT_EQ(writer.trouble(), "");
  EXPECT_EQ(Figure(next, "dynmesh_follower_takeovers_total"), "1");
  EXPECT_NE(next.daemon.Log().find("event=taken_over mesh=m"), std::string::npos);
  EXPECT_TRUE(watch->WaitForRevision(writer.acknowledged(), absl::Minutes(1)));
  EXPECT_EQ(watch->reconnects(), 0);
  EXPECT_EQ(watch->resyncs(), 0);
  Judge(writer);
}

// DYNMESH_CLUSTER_POINTS: of the mesh; default: few. DYNMESH_CLUSTER_FOLLOWERS=0: without
// followers. The time is printed, not judged.
TEST_F(KilledOwnerTest, ALoadedMeshIsWrittenAgainWhenItsLeaseHasEnded) {
  int points = 300;
  if (const char* const given = std::getenv("DYNMESH_CLUSTER_POINTS")) {
    ASSERT_TRUE(absl::SimpleAtoi(given, &points));
  }
  const char* const given = std::getenv("DYNMESH_CLUSTER_FOLLOWERS");
  const bool follows = given == nullptr || std::string(given) != "0";
  more_.insert(more_.end(), {"--followers", follows ? "1" : "0"});
  StartNodes(3, more_);
  ASSERT_FALSE(HasFatalFailure());
  const auto client = Connect();
  ASSERT_TRUE(client->CreateMesh("m", MeshOptions()).ok());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(0.01, 0.99);
  std::vector<Feature> features;
  for (int id = 1; id <= points; ++id) {
    features.push_back(Feature::Point(static_cast<FeatureId>(id), place(random), place(random)));
  }
  const auto loaded = client->Load("m", features);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  if (follows) {
    const Node& next = At(FollowersOf("m").front());
    WaitUntil("the load at the follower",
              [&] { return Figure(next, "dynmesh_follower_revision{mesh=\"m\"}") == "1"; });
  }
  Node& owner = At(OwnerOf("m"));
  std::int64_t left = 0;
  ASSERT_TRUE(absl::SimpleAtoi(
      Sql("SELECT (1000 * extract(epoch FROM lease_until - clock_timestamp()))::bigint FROM "
          "dynmesh.meshes"),
      &left));
  owner.daemon.End(SIGKILL);
  const Clock::time_point killed = Clock::now();
  client::EditParams params;
  params.request_id = "again";
  const EditBatch batch = {Edit::Add(Feature::Point(9'000'000, 0.123, 0.321))};
  absl::StatusOr<client::EditResult> applied;
  WaitUntil("an edit", [&] {
    applied = client->Apply("m", batch, params);
    return applied.ok() || !absl::IsUnavailable(applied.status());
  });
  ASSERT_TRUE(applied.ok()) << applied.status();
  EXPECT_EQ(applied->diff.to_revision, 2u);
  std::printf("{\"points\": %d, \"followers\": %d, \"seconds\": %.3f, \"lease_left\": %.3f}\n",
              points, follows ? 1 : 0, std::chrono::duration<double>(Clock::now() - killed).count(),
              0.001 * static_cast<double>(left));
}

}  // namespace
}  // namespace dynmesh::test
