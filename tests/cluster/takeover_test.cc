// Owners of meshes are killed at any moment. Another node takes their meshes over; every batch that
// was acknowledged is in the journal once and in order, and the mesh is that of its features.
//
// DYNMESH_CLUSTER_KILLS: how often (tests/cluster/run); default: a few times. The times until a
// mesh is written again are printed, not judged.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "absl/strings/numbers.h"
#include "tests/cluster/cluster_fixture.h"
#include "tests/e2e/killed_clients.h"

namespace dynmesh::test {
namespace {

using Clock = std::chrono::steady_clock;

int Kills() {
  int kills = 4;
  const char* const given = std::getenv("DYNMESH_CLUSTER_KILLS");
  if (given != nullptr && !absl::SimpleAtoi(given, &kills)) kills = 0;
  return kills;
}

// Writes batch after batch to a mesh of its own, each with a request id, and again until it is
// acknowledged. Batch k makes revision k.
class Writer {
 public:
  static constexpr std::uint64_t kKept = 60;

  Writer(std::string mesh, std::unique_ptr<client::MeshClient> client)
      : mesh_(std::move(mesh)), client_(std::move(client)) {}
  ~Writer() { Stop(); }

  void Start() {
    ASSERT_TRUE(client_->CreateMesh(mesh_, MeshOptions(), "make-" + mesh_).ok());
    thread_ = std::thread([this] { Run(); });
  }
  void Stop() {
    stopped_ = true;
    if (thread_.joinable()) thread_.join();
  }

  const std::string& mesh() const { return mesh_; }
  std::uint64_t acknowledged() const {
    const std::lock_guard lock(mutex_);
    return times_.empty() ? 0 : times_.rbegin()->first;
  }
  // When the revision was acknowledged.
  Clock::time_point TimeOf(std::uint64_t revision) const {
    const std::lock_guard lock(mutex_);
    return times_.at(revision);
  }
  std::string trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
  }
  std::uint64_t calls() const { return calls_; }

  // The features after the first `batches` batches.
  static EditBatch FeaturesAfter(std::uint64_t batches) {
    EditBatch features;
    for (std::uint64_t k = batches > kKept ? batches - kKept + 1 : 1; k <= batches; ++k) {
      features.push_back(Edit::Add(PointOf(k)));
    }
    return features;
  }

 private:
  // No two of those kept are close: golden steps along both sides of the box.
  static Feature PointOf(std::uint64_t k) {
    const auto part = [k](double step) {
      const double whole = static_cast<double>(k) * step;
      return 0.05 + 0.9 * (whole - std::floor(whole));
    };
    return Feature::Point(k, part(0.7548776662466927), part(0.5698402909980532));
  }
  static EditBatch BatchOf(std::uint64_t k) {
    EditBatch batch = {Edit::Add(PointOf(k))};
    if (k > kKept) batch.push_back(Edit::Remove(k - kKept));
    return batch;
  }

  void Run() {
    for (std::uint64_t k = 1; !stopped_; ++k) {
      client::EditParams params;
      params.request_id = absl::StrCat("w-", k);
      while (true) {
        ++calls_;
        const auto result = client_->Apply(mesh_, BatchOf(k), params);
        if (result.ok()) {
          Took(k, result->diff.to_revision);
          break;
        }
        if (!absl::IsUnavailable(result.status())) {
          const std::lock_guard lock(mutex_);
          trouble_ = result.status().ToString();
          return;
        }
        if (stopped_) return;
      }
    }
  }
  void Took(std::uint64_t batch, std::uint64_t revision) {
    const std::lock_guard lock(mutex_);
    if (revision != batch) trouble_ = absl::StrCat("batch ", batch, " made revision ", revision);
    times_[batch] = Clock::now();
  }

  const std::string mesh_;
  const std::unique_ptr<client::MeshClient> client_;
  std::atomic<bool> stopped_{false};
  std::atomic<std::uint64_t> calls_{0};
  std::thread thread_;
  mutable std::mutex mutex_;
  std::map<std::uint64_t, Clock::time_point> times_;
  std::string trouble_;
};

class TakeoverTest : public ClusterTest {
 protected:
  std::int64_t Number(const std::string& sql) const {
    std::int64_t number = 0;
    if (!absl::SimpleAtoi(Sql(sql), &number)) return 0;
    return number;
  }
  std::int64_t EpochOf(const std::string& mesh) const {
    return Number("SELECT epoch FROM dynmesh.meshes WHERE id = '" + mesh + "'");
  }
  // The first revision of the mesh that was written in a later epoch; 0: none yet.
  std::uint64_t FirstAfter(const std::string& mesh, std::int64_t epoch) const {
    return static_cast<std::uint64_t>(
        Number(absl::StrCat("SELECT min(e.revision) FROM dynmesh.entries AS e JOIN dynmesh.meshes "
                            "AS m ON m.key = e.mesh WHERE m.id = '",
                            mesh, "' AND e.epoch > ", epoch)));
  }

  // Kills the owner of a mesh, and starts it again when its meshes were written by others. Adds how
  // long each of these took.
  void KillOwner(const std::string& mesh, std::vector<double>& seconds) {
    Node& node = At(OwnerOf(mesh));
    std::map<Writer*, std::int64_t> lost;
    for (const auto& writer : writers_) {
      if (OwnerOf(writer->mesh()) == node.address) lost[writer.get()] = EpochOf(writer->mesh());
    }
    const double left =
        0.001 *
        static_cast<double>(Number(
            "SELECT (1000 * extract(epoch FROM max(lease_until) - clock_timestamp()))::bigint FROM "
            "dynmesh.meshes AS m JOIN dynmesh.nodes AS n ON n.id = m.owner WHERE n.address = '" +
            node.address + "'"));
    node.daemon.End(SIGKILL);
    const Clock::time_point killed = Clock::now();
    for (const auto& [writer, epoch] : lost) {
      std::uint64_t first = 0;
      WaitUntil("a batch at the next owner of " + writer->mesh(), [&, w = writer, e = epoch] {
        if (!w->trouble().empty()) return true;
        if (first == 0) first = FirstAfter(w->mesh(), e);
        return first > 0 && w->acknowledged() >= first;
      });
      ASSERT_EQ(writer->trouble(), "") << node.daemon.Log();
      seconds.push_back(std::chrono::duration<double>(writer->TimeOf(first) - killed).count());
      std::printf("%s at revision %llu: written again after %.3f s; the lease had %.3f s left\n",
                  writer->mesh().c_str(), static_cast<unsigned long long>(first), seconds.back(),
                  left);
    }
    Restart(node);
  }

  void Judge(const Writer& writer) {
    SCOPED_TRACE(writer.mesh());
    EXPECT_EQ(writer.trouble(), "");
    const std::string of_mesh =
        " FROM dynmesh.requests AS r JOIN dynmesh.meshes AS m ON m.key = "
        "r.mesh WHERE m.id = '" +
        writer.mesh() + "'";
    const auto head = static_cast<std::uint64_t>(
        Number("SELECT head FROM dynmesh.meshes WHERE id = '" + writer.mesh() + "'"));
    // The last one may have no answer.
    EXPECT_GE(head, writer.acknowledged());
    EXPECT_LE(head, writer.acknowledged() + 1);
    // Request n is of batch n: each is there once, in order. The oldest are forgotten.
    EXPECT_EQ(Number("SELECT max(number)" + of_mesh), static_cast<std::int64_t>(head));
    EXPECT_EQ(
        Number("SELECT count(*)" + of_mesh + " AND convert_from(r.id, 'UTF8') <> 'w-' || r.number"),
        0);
    EXPECT_EQ(Number("SELECT count(*) - (max(number) - min(number) + 1)" + of_mesh), 0);
    const auto found = Connect()->GetMesh(writer.mesh());
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(found->revision, head);
    const auto scratch = DynamicMesh::Create(MeshOptions());
    ASSERT_TRUE(scratch.ok());
    ASSERT_TRUE((*scratch)->Apply(Writer::FeaturesAfter(head)).ok());
    EXPECT_EQ(found->hash, (*scratch)->hash());
    const auto snapshot = Connect()->GetSnapshot(writer.mesh());
    ASSERT_TRUE(snapshot.ok()) << snapshot.status();
    EXPECT_EQ(ComputeHash(*snapshot), (*scratch)->hash());
  }

  std::vector<std::unique_ptr<Writer>> writers_;
};

double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(part * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

TEST_F(TakeoverTest, AKilledOwnersMeshesGoOnAtAnotherNodeAndNothingIsLostOrDoubled) {
  const int kills = Kills();
  ASSERT_GT(kills, 0) << "DYNMESH_CLUSTER_KILLS is no number above 0";
  const std::uint64_t seed = Seed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  std::mt19937_64 random(seed);
  StartNodes(3);
  ASSERT_FALSE(HasFatalFailure());
  for (int i = 0; i < 4; ++i) {
    writers_.push_back(std::make_unique<Writer>(absl::StrCat("m", i), Connect()));
    writers_.back()->Start();
    ASSERT_FALSE(HasFatalFailure());
  }
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
