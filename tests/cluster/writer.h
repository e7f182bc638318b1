// A mesh that is written to without end, and what must be true of it afterwards.
#ifndef DYNMESH_TESTS_CLUSTER_WRITER_H_
#define DYNMESH_TESTS_CLUSTER_WRITER_H_

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/numbers.h"
#include "tests/cluster/cluster_fixture.h"

namespace dynmesh::test {

using Clock = std::chrono::steady_clock;

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
  // Calls that ended with an error: the client library repeats the others by itself.
  std::uint64_t errors() const { return errors_; }
  // The longest time between two acknowledged batches, the second of them after `since`.
  double LongestPause(Clock::time_point since) const {
    const std::lock_guard lock(mutex_);
    Clock::duration longest{0};
    for (auto it = times_.rbegin(); it != times_.rend() && it->second > since; ++it) {
      const auto before = std::next(it);
      if (before != times_.rend()) longest = std::max(longest, it->second - before->second);
    }
    return std::chrono::duration<double>(longest).count();
  }

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
        ++errors_;
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
  std::atomic<std::uint64_t> calls_{0}, errors_{0};
  std::thread thread_;
  mutable std::mutex mutex_;
  std::map<std::uint64_t, Clock::time_point> times_;
  std::string trouble_;
};

// Reads the revision of a writer's mesh without end, at one node, which sends it to the mesh's
// owner.
class Reader {
 public:
  Reader(const Writer& writer, std::unique_ptr<client::MeshClient> client)
      : writer_(writer), client_(std::move(client)), thread_([this] { Run(); }) {}
  ~Reader() { Stop(); }

  void Stop() {
    stopped_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::uint64_t reads() const { return reads_; }
  std::uint64_t errors() const { return errors_; }
  // Reads that did not tell of a batch that had been acknowledged before they began.
  std::uint64_t stale() const { return stale_; }

 private:
  void Run() {
    while (!stopped_) {
      const std::uint64_t acknowledged = writer_.acknowledged();
      const auto found = client_->GetMesh(writer_.mesh());
      if (found.ok()) {
        ++reads_;
        stale_ += found->revision < acknowledged;
      } else {
        ++errors_;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  const Writer& writer_;
  const std::unique_ptr<client::MeshClient> client_;
  std::atomic<bool> stopped_{false};
  std::atomic<std::uint64_t> reads_{0}, errors_{0}, stale_{0};
  std::thread thread_;
};

// The number of that variable of the environment; 0 if it is none.
inline int CountFrom(const char* variable, int count) {
  const char* const given = std::getenv(variable);
  if (given != nullptr && !absl::SimpleAtoi(given, &count)) count = 0;
  return count;
}

// A cluster with writers.
class WriterTest : public ClusterTest {
 protected:
  using ClusterTest::ClusterTest;

  void StartWriters(int count) {
    for (int i = 0; i < count; ++i) {
      writers_.push_back(std::make_unique<Writer>(absl::StrCat("m", i), Connect()));
      writers_.back()->Start();
      if (HasFatalFailure()) return;
    }
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
  // The writers whose meshes a node has, and the epochs of these.
  std::map<Writer*, std::int64_t> WrittenAt(const Node& node) const {
    std::map<Writer*, std::int64_t> written;
    for (const auto& writer : writers_) {
      if (OwnerOf(writer->mesh()) == node.address) written[writer.get()] = EpochOf(writer->mesh());
    }
    return written;
  }
  // Waits until a batch of a later epoch is acknowledged, or the writer is in trouble. Returns the
  // first revision of that epoch.
  std::uint64_t AwaitNextOwner(const Writer& writer, std::int64_t epoch) {
    std::uint64_t first = 0;
    WaitUntil("a batch at the next owner of " + writer.mesh(), [&] {
      if (!writer.trouble().empty()) return true;
      if (first == 0) first = FirstAfter(writer.mesh(), epoch);
      return first > 0 && writer.acknowledged() >= first;
    });
    return first;
  }

  std::int64_t Number(const std::string& sql) const {
    std::int64_t number = 0;
    if (!absl::SimpleAtoi(Sql(sql), &number)) return 0;
    return number;
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
    // One owner after the other has written.
    EXPECT_EQ(
        Number("SELECT count(*) FROM (SELECT e.epoch, lag(e.epoch) OVER (ORDER BY e.revision) "
               "AS before FROM dynmesh.entries AS e JOIN dynmesh.meshes AS m ON m.key = "
               "e.mesh WHERE m.id = '" +
               writer.mesh() + "') AS x WHERE epoch < before"),
        0);
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

inline double Quantile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(part * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_CLUSTER_WRITER_H_
