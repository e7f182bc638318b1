// Limits for clients, tested from both sides. service_test.cc has those of meshes, batches and
// streams, mesh_host_test.cc that of the jobs that wait for a mesh.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <thread>

#include "dynmesh/error.h"
#include "tests/server/server_fixture.h"
#include "tests/support/deadline.h"

namespace dynmesh::server::limits_test {
namespace {

using LimitsTest = ServerFixture;

TEST_F(LimitsTest, FeaturesOfAMesh) {
  ServerConfig config;
  config.max_features = 3;
  StartWithMesh(config);
  ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
  const absl::Status refused = client_->Apply("m", {AddPoint(4)}).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(refused), codec::reason::kFeatureLimit);
  EXPECT_FALSE(codec::GetServiceError(refused)->retry_after.has_value());  // waiting is no help
  EXPECT_EQ(HeadOf().revision, 1u);
  EXPECT_TRUE(client_->Apply("m", {Edit::Remove(1), AddPoint(4)}).ok());
  EXPECT_TRUE(client_->Apply("m", {Edit::Remove(2)}).ok());
  EXPECT_TRUE(client_->Apply("m", {AddPoint(5)}).ok());
}

TEST_F(LimitsTest, OperationsOfABatch) {
  ServerConfig config;
  config.max_batch_operations = 2;
  StartWithMesh(config);
  EXPECT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2)}).ok());
  const absl::Status refused =
      client_->Apply("m", {AddPoint(3), AddPoint(4), AddPoint(5)}).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(refused), dynmesh::reason::kWorkLimit);
  EXPECT_EQ(HeadOf().revision, 1u);
}

// By default, as many as half of the memory holds.
TEST_F(LimitsTest, VerticesOfAMeshFollowFromTheMemory) {
  const auto of = [&](const char* mesh, int dimension) {
    MeshOptions options;
    options.dimension = dimension;
    options.quality = 2;
    EXPECT_TRUE(client_->CreateMesh(mesh, options).ok());
    const auto info = client_->GetMesh(mesh);
    EXPECT_TRUE(info.ok());
    return info->options.limits.max_vertices;
  };
  ServerConfig config;
  config.max_memory_bytes = std::uint64_t{100} << 30;
  StartServer(config);
  const std::uint64_t planar = of("planar", 2), spatial = of("spatial", 3);
  EXPECT_EQ(planar, config.max_memory_bytes / 2 / 1000);
  EXPECT_EQ(spatial, config.max_memory_bytes / 2 / 2500);
  MeshOptions larger;
  larger.limits.max_vertices = planar + 1;
  EXPECT_EQ(client_->CreateMesh("larger", larger).status().code(),
            absl::StatusCode::kInvalidArgument);
  config.max_vertices = 12'345;
  StartServer(config);
  EXPECT_EQ(of("m", 2), 12'345u);
}

TEST_F(LimitsTest, RequestsASecond) {
  ServerConfig config;
  config.max_requests_per_second = 2;  // the call that opens a stream counts, too
  StartWithMesh(config);
  absl::Status status;
  test::WaitUntil("three calls within a second", [&] {
    status = client_->GetMesh("m").status();
    return !status.ok();
  });
  EXPECT_EQ(ReasonOf(status), codec::reason::kRateLimit);
  const absl::Duration wait = *codec::GetServiceError(status)->retry_after;
  EXPECT_LE(wait, absl::Seconds(1));
  absl::SleepFor(wait + absl::Milliseconds(50));
  EXPECT_TRUE(client_->GetMesh("m").ok());
  // Batches of a stream count, one by one.
  absl::SleepFor(absl::Seconds(1));
  const auto edits = client_->OpenEdits("m");
  for (FeatureId id = 1; id <= 40; ++id) ASSERT_TRUE(edits->Send({AddPoint(id)}).ok());
  ASSERT_TRUE(edits->DoneSending().ok());
  int applied = 0;
  while (const auto answer = edits->Receive()) applied += answer->result.ok() ? 1 : 0;
  EXPECT_GE(applied, 1);
  EXPECT_LT(applied, 40);  // that takes 19 seconds
  EXPECT_EQ(HeadOf().revision, static_cast<std::uint64_t>(applied));
}

// The test sets the process's memory size, since the system (and a sanitizer) decides when free
// memory is returned.
class MemoryLimitTest : public ServerFixture {
 protected:
  static constexpr std::uint64_t kLimit = 1'000'000'000;
  static inline std::atomic<std::uint64_t> resident = 0;

  void Start() {
    ServerConfig config;
    config.max_memory_bytes = kLimit;
    resident = kLimit / 2;
    config.resident_bytes = [] { return resident.load(); };
    StartWithMesh(config);
    ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2)}).ok());
  }
  // Until the server has measured.
  absl::Status Until(bool ok, FeatureId id) {
    absl::Status status;
    test::WaitUntil("a measurement", [&] {
      status = client_->Apply("m", {AddPoint(id)}).status();
      if (status.ok() == ok) return true;
      if (status.ok()) {
        EXPECT_TRUE(client_->Apply("m", {Edit::Remove(id)}).ok());
      }
      absl::SleepFor(absl::Milliseconds(50));
      return false;
    });
    return status;
  }
};

TEST_F(MemoryLimitTest, AboveItNothingGrowsAndTheRestGoesOn) {
  Start();
  resident = kLimit + 1;
  const absl::Status refused = Until(false, 3);
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(refused), codec::reason::kMemoryLimit);
  EXPECT_TRUE(codec::GetServiceError(refused)->retry_after.has_value());
  EXPECT_EQ(ReasonOf(client_->CreateMesh("n", {}).status()), codec::reason::kMemoryLimit);
  EXPECT_TRUE(client_->Apply("m", {Edit::Remove(1)}).ok());
  EXPECT_TRUE(client_->GetSnapshot("m").ok());
  const auto watch = client_->Watch("m", {}, nullptr);
  EXPECT_TRUE(watch->WaitForRevision(HeadOf().revision, kLong));
  resident = kLimit;
  EXPECT_TRUE(Until(true, 4).ok());
  EXPECT_TRUE(client_->CreateMesh("n", {}).ok());
}

TEST_F(MemoryLimitTest, ABatchUnderWayIsUndone) {
  Start();
  gate_->Hold();
  Mailbox<absl::Status> held;
  std::thread waiting([&] { held.Put(client_->Apply("m", {AddPoint(3)}).status()); });
  gate_->WaitForArrivals(2);
  resident = kLimit + 1;
  const absl::Status status = held.Take();
  EXPECT_EQ(ReasonOf(status), codec::reason::kMemoryLimit) << Text(status);
  EXPECT_EQ(HeadOf().revision, 1u);
  waiting.join();
  gate_->Release();
}

}  // namespace
}  // namespace dynmesh::server::limits_test
