// Owners of meshes are killed at any moment. Another node takes their meshes over; every batch that
// was acknowledged is in the journal once and in order, and the mesh is that of its features.
//
// DYNMESH_CLUSTER_KILLS: how often (tests/cluster/run); default: a few times. The times until a
// mesh is written again are printed, not judged.
#include <cstdio>
#include <map>
#include <random>
#include <thread>

#include "tests/cluster/writer.h"
#include "tests/e2e/killed_clients.h"

namespace dynmesh::test {
namespace {

class TakeoverTest : public WriterTest {
 protected:
  // Kills the owner of a mesh, and starts it again when its meshes were written by others. Adds how
  // long each of these took.
  void KillOwner(const std::string& mesh, std::vector<double>& seconds) {
    Node& node = At(OwnerOf(mesh));
    const std::map<Writer*, std::int64_t> lost = WrittenAt(node);
    const double left =
        0.001 *
        static_cast<double>(Number(
            "SELECT (1000 * extract(epoch FROM max(lease_until) - clock_timestamp()))::bigint FROM "
            "dynmesh.meshes AS m JOIN dynmesh.nodes AS n ON n.id = m.owner WHERE n.address = '" +
            node.address + "'"));
    node.daemon.End(SIGKILL);
    const Clock::time_point killed = Clock::now();
    for (const auto& [writer, epoch] : lost) {
      const std::uint64_t first = AwaitNextOwner(*writer, epoch);
      ASSERT_EQ(writer->trouble(), "") << node.daemon.Log();
      seconds.push_back(std::chrono::duration<double>(writer->TimeOf(first) - killed).count());
      std::printf("%s at revision %llu: written again after %.3f s; the lease had %.3f s left\n",
                  writer->mesh().c_str(), static_cast<unsigned long long>(first), seconds.back(),
                  left);
    }
    Restart(node);
  }
};

TEST_F(TakeoverTest, AKilledOwnersMeshesGoOnAtAnotherNodeAndNothingIsLostOrDoubled) {
  const int kills = CountFrom("DYNMESH_CLUSTER_KILLS", 4);
  ASSERT_GT(kills, 0) << "DYNMESH_CLUSTER_KILLS is no number above 0";
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  StartNodes(3);
  ASSERT_FALSE(HasFatalFailure());
  StartWriters(4);
  ASSERT_FALSE(HasFatalFailure());
  std::vector<double> seconds;
  for (int i = 0; i < kills; ++i) {
    SCOPED_TRACE(absl::StrCat("kill ", i));
    // At any moment between two renewals. The first one after a take-over is waited for: a lease
    // that has just begun is longer than most.
    std::this_thread::sleep_for(std::chrono::microseconds(1'500'000 + random() % 1'500'000));
    KillOwner(writers_[random() % writers_.size()]->mesh(), seconds);
    if (HasFailure()) break;
  }
  std::uint64_t acknowledged = 0, calls = 0;
  for (const auto& writer : writers_) {
    writer->Stop();
    acknowledged += writer->acknowledged();
    calls += writer->calls();
  }
  for (const auto& writer : writers_) Judge(*writer);
  std::printf(
      "{\"kills\": %d, \"meshes_taken_over\": %zu, \"acknowledged\": %llu, \"calls\": %llu, "
      "\"p50_seconds\": %.3f, \"p99_seconds\": %.3f, \"max_seconds\": %.3f}\n",
      kills, seconds.size(), static_cast<unsigned long long>(acknowledged),
      static_cast<unsigned long long>(calls), Quantile(seconds, 0.5), Quantile(seconds, 0.99),
      Quantile(seconds, 1));
  EXPECT_GT(acknowledged, static_cast<std::uint64_t>(kills));
}

}  // namespace
}  // namespace dynmesh::test
