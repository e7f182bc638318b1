// Hostile clients on real sockets. After each of them the server answers others within a second,
// has not grown, and nothing has changed.
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <random>
#include <thread>
#include <vector>

#include "proto/codec/token_hash.h"
#include "server/base/process.h"
#include "tests/server/server_fixture.h"
#include "tests/support/raw_http2.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::hostile_test {
namespace {

using test::RawConnection;

#ifdef __SANITIZE_THREAD__  // which keeps four bytes beside each
constexpr std::uint64_t kMostGrowth = std::uint64_t{512} << 20;
#else
constexpr std::uint64_t kMostGrowth = std::uint64_t{128} << 20;
#endif

class HostileTest : public ServerFixture {
 protected:
  // Soon enough for a test that waits for it.
  static ServerConfig AsksSoon() {
    ServerConfig config;
    config.keepalive_interval = absl::Milliseconds(300);
    config.keepalive_timeout = absl::Milliseconds(500);
    return config;
  }
  void Start(const ServerConfig& config = {}) {
    StartWithMesh(config);
    ASSERT_TRUE(client_->Apply("m", {AddPoint(1), AddPoint(2), AddPoint(3)}).ok());
    before_ = HeadOf();
    resident_ = ResidentBytes();
  }

  RawConnection Open() const { return RawConnection(server_->port()); }

  // A new client connects, reads and writes.
  void ExpectServed() {
    EXPECT_EQ(HeadOf().revision, before_.revision);
    EXPECT_EQ(HeadOf().hash, before_.hash);
    absl::Duration best = absl::InfiniteDuration();
    // Several times, for machines that are busy with other things.
    for (int i = 0; i < 20 && best > absl::Seconds(1); ++i) {
      const absl::Time start = absl::Now();
      client::ClientOptions options;
      options.own_connection = true;
      options.timeout = absl::Seconds(10);
      const auto client = client::MeshClient::Connect(server_->address(), options);
      const FeatureId id = ++next_id_;
      const bool ok = client->Apply("m", {AddPoint(id)}).ok() &&
                      client->Apply("m", {Edit::Remove(id)}).ok() && client->GetMesh("m").ok();
      if (ok) best = std::min(best, absl::Now() - start);
    }
    EXPECT_LT(best, absl::Seconds(1));
    EXPECT_EQ(HeadOf().hash, before_.hash);
    before_ = HeadOf();
    EXPECT_LT(ResidentBytes(), resident_ + kMostGrowth);
  }

  Head before_;
  std::uint64_t resident_ = 0;
  FeatureId next_id_ = 100;
};

std::string WatchOfM() {
  v1::WatchRequest request;
  request.set_mesh("meshes/m");
  return request.SerializeAsString();
}

TEST_F(HostileTest, ConnectionsThatSayNothingAreClosed) {
  ServerConfig config;
  config.handshake_timeout = absl::Seconds(3);  // the test's own clients keep it, too
  Start(config);
  std::vector<RawConnection> silent;
  for (int i = 0; i < 400; ++i) {
    silent.push_back(Open());
    ASSERT_TRUE(silent.back().connected());
  }
  ExpectServed();
  for (RawConnection& connection : silent) ASSERT_TRUE(connection.WaitForClose(20'000));
  ExpectServed();
}

TEST_F(HostileTest, ConnectionsAboveTheLimitAreClosedAtOnce) {
  ServerConfig config;
  config.max_connections = 50;
  Start(config);
  {
    std::vector<RawConnection> many;
    for (int i = 0; i < 300; ++i) {
      many.push_back(Open());
      many.back().Greet();
    }
    // The server sends its settings on an accepted connection.
    int refused = 0;
    for (RawConnection& connection : many) refused += connection.IsRefused(20'000) ? 1 : 0;
    EXPECT_GE(refused, 250);
    // Older connections are still served.
    EXPECT_TRUE(client_->GetMesh("m").ok());
  }
  EXPECT_TRUE(Eventually([&] {
    client::ClientOptions options;
    options.own_connection = true;
    return client::MeshClient::Connect(server_->address(), options)->GetMesh("m").ok();
  }));
  ExpectServed();
}

// Calls that are begun and reset, on one connection after the other, from another address of this
// machine. gRPC does not count them, and the calls of others would wait behind all of them.
TEST_F(HostileTest, CallsThatAreResetAtOnceAreCutOffAndDelayNoOtherAddress) {
  test::TempFolder folder;
  std::ofstream(folder.path() + "/tokens")
      << "lab " << codec::ToHex(codec::HashToken("lab")) << " admin=*\n";
  ServerConfig config;
  config.tokens_file = folder.path() + "/tokens";
  config.max_new_connections_per_second = 1;
  config.max_wasted_calls_per_second = 100;
  StartServer(config);
  constexpr std::uint32_t kCalls = 4'000;
  std::string calls;
  for (std::uint32_t i = 0; i < kCalls; ++i) {
    calls += RawConnection::CallFrame(2 * i + 1, "GetMesh") + RawConnection::ResetFrame(2 * i + 1);
  }
  std::atomic<bool> done{false};
  std::atomic<std::uint64_t> attacks{0};
  const auto attack = [&] {
    while (!done) {
      RawConnection connection(server_->port(), "127.0.0.2");
      if (!connection.connected() || !connection.Greet()) continue;
      // The server cuts it in the middle, or soon after, or has refused it.
      connection.SendAll(calls);
      ++attacks;
      connection.WaitForClose(20'000);
    }
  };
  std::vector<std::thread> attackers;
  for (int i = 0; i < 4; ++i) attackers.emplace_back(attack);
  // Others are served meanwhile, again and again, on new connections.
  client::ClientOptions options;
  options.own_connection = true;
  options.token = "lab";
  options.timeout = kLong;
  int served = 0;
  while (served < 20 || attacks < 100) {
    const auto client = client::MeshClient::Connect(server_->address(), options);
    ASSERT_TRUE(client->ListMeshes().ok());
    ++served;
  }
  done = true;
  for (std::thread& attacker : attackers) attacker.join();
  // Without the limits, nearly all of the calls would be begun.
  const ConnectionTable::Counts counts = server_->connections();
  EXPECT_GT(counts.cut, 0u);
  EXPECT_GT(counts.refused, 0u);
  EXPECT_LT(counts.wasted, kCalls * attacks / 5);
}

TEST_F(HostileTest, AWatchWhoseClientVanishedIsForgotten) {
  Start(AsksSoon());
  RawConnection half_open = Open();
  ASSERT_TRUE(half_open.Greet());
  ASSERT_TRUE(half_open.Call(1, "Watch"));
  ASSERT_TRUE(half_open.Message(1, WatchOfM(), /*end=*/true));
  ASSERT_TRUE(Eventually([&] { return Host()->hub()->size() == 1; }));
  // It answers no ping from here on.
  EXPECT_TRUE(Eventually([&] { return Host()->hub()->size() == 0; }));
  ExpectServed();
}

TEST_F(HostileTest, ABatchThatNeverEndsHoldsNothingForLong) {
  ServerConfig config = AsksSoon();
  config.max_pending_edits = config.max_batch_edits = 10;
  Start(config);
  v1::EditBatch part;
  part.set_mesh("meshes/m");
  part.set_more(true);
  for (int i = 0; i < 8; ++i) part.add_edits()->set_remove(1);
  const auto can_edit = [&] {
    client::EditParams params;
    params.validate_only = true;
    const EditBatch three = {AddPoint(10), AddPoint(11), AddPoint(12)};
    return ReasonOf(client_->Apply("m", three, params).status()) != codec::reason::kPendingLimit;
  };
  // The test's own query reserves edits, too: a batch that arrives meanwhile is refused.
  std::vector<RawConnection> half_open;
  ASSERT_TRUE(Eventually([&] {
    if (!can_edit()) return true;
    half_open.clear();
    half_open.push_back(Open());
    EXPECT_TRUE(half_open[0].Greet() && half_open[0].Call(1, "EditStream") &&
                half_open[0].Message(1, part.SerializeAsString(), /*end=*/false));
    return false;
  }));
  // It answers no ping from here on.
  EXPECT_TRUE(Eventually(can_edit));
  ExpectServed();
}

TEST_F(HostileTest, WatchersThatNeverReadCostLittle) {
  ServerConfig config;
  config.history_revisions = 20;
  Start(config);
  std::vector<RawConnection> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(Open());
    ASSERT_TRUE(slow.back().Greet() && slow.back().Call(1, "Watch") &&
                slow.back().Message(1, WatchOfM(), /*end=*/true));
  }
  EditBatch add, remove;
  for (FeatureId id = 1000; id < 4000; ++id) {
    add.push_back(AddPoint(id));
    remove.push_back(Edit::Remove(id));
  }
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(client_->Apply("m", add).ok());
    ASSERT_TRUE(client_->Apply("m", remove).ok());
  }
  EXPECT_EQ(HeadOf().hash, before_.hash);
  before_ = HeadOf();
  ExpectServed();
}

TEST_F(HostileTest, GarbageIsNoRequest) {
  Start();
  const std::uint64_t seed = test::NewSeed();
  std::mt19937 random(seed);
  for (int i = 0; i < 200; ++i) {
    std::string bytes(random() % 8192, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    RawConnection connection = Open();
    ASSERT_TRUE(connection.connected());
    if (i % 2 == 1) connection.Greet();
    if (i % 4 == 3) bytes = RawConnection::Frame(static_cast<int>(random() % 12), 5, 1, bytes);
    connection.Send(bytes);
    if (i % 8 == 7) connection.WaitForClose(10);
  }
  ExpectServed();
}

TEST_F(HostileTest, LiesAboutLengthsCostNothing) {
  Start();
  std::vector<RawConnection> liars;
  for (int i = 0; i < 50; ++i) {
    liars.push_back(Open());
    RawConnection& liar = liars.back();
    ASSERT_TRUE(liar.Greet());
    ASSERT_TRUE(liar.Call(1, "ApplyEdits"));
    // A message of two gigabytes, of which a kilobyte comes.
    const std::string start =
        std::string(1, '\0') + RawConnection::Number(0x7fffffff, 4) + std::string(1024, 'x');
    liar.Send(RawConnection::Frame(0, 0, 1, start));
    liar.Call(3, "ApplyEdits");
    // A frame that claims to be longer than frames may be.
    liar.Send(RawConnection::Number(0xffffff, 3) + std::string(1, '\0') + std::string(1, '\0') +
              RawConnection::Number(3, 4) + std::string(1024, 'x'));
  }
  ExpectServed();
}

TEST_F(HostileTest, MessagesThatAreTooLargeAreRefused) {
  ServerConfig config;
  config.max_message_bytes = 64 << 10;
  Start(config);
  v1::ApplyEditsRequest request;
  request.set_mesh("meshes/m");
  request.set_request_id(std::string(100 << 10, 'x'));
  for (int i = 0; i < 20; ++i) {
    grpc::ClientContext context;
    const auto reader = stub_->ApplyEdits(&context, request);
    v1::MeshDiff diff;
    EXPECT_FALSE(reader->Read(&diff));
    const grpc::Status status = reader->Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
  }
  request.set_request_id(std::string(60 << 10, 'x'));  // too long an id, but not a message
  grpc::ClientContext context;
  const auto reader = stub_->ApplyEdits(&context, request);
  v1::MeshDiff diff;
  EXPECT_FALSE(reader->Read(&diff));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  ExpectServed();
}

TEST_F(HostileTest, CallsCancelledInTheMiddleChangeNothing) {
  Start();
  gate_->Hold();
  for (int i = 0; i < 20; ++i) {
    v1::ApplyEditsRequest request;
    request.set_mesh("meshes/m");
    request.add_edits()->set_remove(1);
    RawConnection connection = Open();
    ASSERT_TRUE(connection.Greet() && connection.Call(1, "ApplyEdits") &&
                connection.Message(1, request.SerializeAsString(), /*end=*/true));
    gate_->WaitForArrivals(i + 2);
    connection.Close();  // not a word
  }
  Mailbox<int> turn;  // after all of them
  ASSERT_TRUE(Host()->Locate({}, nullptr, [&](auto) { turn.Put(0); }).ok());
  turn.Take();
  gate_->Release();
  ExpectServed();
}

}  // namespace
}  // namespace dynmesh::server::hostile_test
