// Owners of meshes are stopped for longer than their lease, as by a machine that sleeps, and go on
// as if nothing had been. Another node has the meshes by then: what the old owner had under way is
// refused, and it answers no read from its own state.
//
// DYNMESH_CLUSTER_STOPS: how often (tests/cluster/run); default: twice. DYNMESH_CLUSTER_STOP: for
// how many seconds.
#include <cstdio>
#include <random>
#include <thread>

#include "tests/cluster/writer.h"
#include "tests/e2e/killed_clients.h"

namespace dynmesh::test {
namespace {

class StoppedOwnerTest : public WriterTest {
 protected:
  StoppedOwnerTest() : WriterTest("1") {}

  std::vector<std::unique_ptr<Reader>> readers_;
};

TEST_F(StoppedOwnerTest, WritesAndReadsGoOnAtAnotherNodeAndTheOldOwnerIsFenced) {
  const int stops = CountFrom("DYNMESH_CLUSTER_STOPS", 2);
  ASSERT_GT(stops, 0) << "DYNMESH_CLUSTER_STOPS is no number above 0";
  const int length = CountFrom("DYNMESH_CLUSTER_STOP", 3);
  const std::uint64_t seed = NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  StartNodes(3);
  ASSERT_FALSE(HasFatalFailure());
  StartWriters(3);
  ASSERT_FALSE(HasFatalFailure());
  // A call that waits at a stopped node is answered when that goes on.
  for (const auto& writer : writers_) {
    for (const auto& node : nodes_) {
      readers_.push_back(std::make_unique<Reader>(*writer, Connect(node->address)));
    }
  }
  std::vector<double> seconds;
  for (int i = 0; i < stops && !HasFailure(); ++i) {
    SCOPED_TRACE(absl::StrCat("stop ", i));
    std::this_thread::sleep_for(std::chrono::microseconds(500'000 + random() % 1'000'000));
    Node& node = At(OwnerOf(writers_[random() % writers_.size()]->mesh()));
    const std::map<Writer*, std::int64_t> lost = WrittenAt(node);
    node.daemon.Signal(SIGSTOP);
    const Clock::time_point stopped = Clock::now();
    for (const auto& [writer, epoch] : lost) {
      const std::uint64_t first = AwaitNextOwner(*writer, epoch);
      EXPECT_EQ(writer->trouble(), "");
      if (HasFailure()) break;
      seconds.push_back(std::chrono::duration<double>(writer->TimeOf(first) - stopped).count());
    }
    std::this_thread::sleep_until(stopped + std::chrono::seconds(length));
    node.daemon.Signal(SIGCONT);
    // It answers again, and is not the owner of what it had.
    WaitUntil("an answer of the node that was stopped",
              [&] { return Connect(node.address)->GetMesh(writers_[0]->mesh()).ok(); });
    for (const auto& [writer, epoch] : lost) EXPECT_GT(EpochOf(writer->mesh()), epoch);
  }
  std::uint64_t reads = 0, failed = 0, stale = 0, acknowledged = 0;
  for (const auto& writer : writers_) writer->Stop();
  for (const auto& reader : readers_) {
    reader->Stop();
    reads += reader->reads(), failed += reader->errors(), stale += reader->stale();
  }
  for (const auto& writer : writers_) {
    acknowledged += writer->acknowledged();
    Judge(*writer);
  }
  EXPECT_EQ(stale, 0U);
  EXPECT_GT(reads, 0U);
  std::printf(
      "{\"stops\": %d, \"meshes_taken_over\": %zu, \"acknowledged\": %llu, \"reads\": %llu, "
      "\"failed_reads\": %llu, \"stale_reads\": %llu, \"p50_seconds\": %.3f, "
      "\"p99_seconds\": %.3f, \"max_seconds\": %.3f}\n",
      stops, seconds.size(), static_cast<unsigned long long>(acknowledged),
      static_cast<unsigned long long>(reads), static_cast<unsigned long long>(failed),
      static_cast<unsigned long long>(stale), Quantile(seconds, 0.5), Quantile(seconds, 0.99),
      Quantile(seconds, 1));
}

}  // namespace
}  // namespace dynmesh::test
