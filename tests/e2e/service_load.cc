// Figures of the service over loopback, with real meshes: a tool, not a test.
// What it takes is in kHelp.
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "client/cli/percentile.h"
#include "dynmesh/client/mesh_client.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "server/base/log.h"
#include "server/journal/sqlite_journal.h"
#include "server/server.h"
#include "tests/e2e/many_meshes.h"
#include "tests/e2e/random_edits.h"
#include "tests/e2e/raw_watchers.h"

namespace dynmesh {
namespace {

constexpr char kHelp[] =
    "service_load [--server=ADDRESS | --data-dir=FOLDER] [POINTS [PART...]]\n"
    "Figures of the service over loopback. The server is in this process unless an address is\n"
    "given: better for profiles, worse for figures, because gRPC then runs the calls of both "
    "sides\n"
    "on the same few threads.\n"
    "POINTS is the size of the mesh to work on, 1 to 10000000 (default 20000).\n"
    "With a journal: --data-dir for the server in this process, or a server that has one.\n"
    "PARTs are overhead, edits, stream, requests (edits and stream with and without request ids,\n"
    "in turn), watchers, fanout (200 watchers that read bytes and hold no mesh), silent, snapshot\n"
    "and meshes (64 of POINTS / 64 points, edited at once, in 2D and in 3D). Default: all.\n"
    "With --server=ADDRESS,ADDRESS... of servers that share their meshes: edits, stream, requests\n"
    "and meshes.\n"
    "An edit adds a point anywhere or removes one added before; one a batch.\n";
constexpr std::size_t kMostPoints = 10'000'000;
constexpr std::array<std::string_view, 9> kParts = {"overhead", "edits",    "stream",
                                                    "requests", "watchers", "fanout",
                                                    "silent",   "snapshot", "meshes"};

using Clock = std::chrono::steady_clock;

double Microseconds(Clock::duration d) {
  return std::chrono::duration<double, std::micro>(d).count();
}

void Check(const absl::Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "%s\n", std::string(status.ToString()).c_str());
  std::exit(1);
}

using cli::Percentile;

class Load {
 public:
  Load(std::size_t points, std::string address, const std::string& data_dir)
      : points_(points), address_(std::move(address)) {
    if (address_.empty()) {
      server::ServerConfig config;
      config.listen = "127.0.0.1:0";
      std::unique_ptr<server::Journal> journal;
      if (!data_dir.empty()) {
        auto opened = server::SqliteJournal::Open(data_dir, server::SqliteJournal::Options());
        Check(opened.status());
        journal = *std::move(opened);
      }
      auto server = server::Server::Start(config, &DynamicMesh::Create, std::move(journal));
      Check(server.status());
      server_ = *std::move(server);
      address_ = server_->address();
    }
    client_ = client::MeshClient::Connect(address_);
    Check(client_->CreateMesh("m", MeshOptions()).status());
  }
  ~Load() { Check(client_->DeleteMesh("m")); }

  void Run(const std::vector<std::string>& parts) {
    const auto wants = [&](const char* part) {
      return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
    };
    Fill();
    if (wants("overhead")) Overhead();
    if (wants("edits")) SingleEdits();
    if (wants("stream")) Stream();
    if (wants("requests")) Requests();
    if (wants("watchers")) {
      StreamWithWatchers(1);
      // A replica takes about 300 bytes a vertex; all are in this process.
      StreamWithWatchers(static_cast<int>(std::clamp<std::size_t>(6'000'000 / points_, 2, 200)));
    }
    if (wants("fanout")) {
      Fanout("EditStream", 4'000, [this](int n) { return StreamEdits(n); });
      Fanout("ApplyEdits", 1'000, [this](int n) { return CallEdits(n); });
    }
    if (wants("silent")) SilentWatcher();
    if (wants("snapshot")) Snapshot();
    if (wants("meshes")) ManyMeshes();
  }

 private:
  void Fill() {
    const EditBatch batch = edits_.Fill(points_);
    client::EditParams params;
    params.omit_columns = true;
    const auto start = Clock::now();
    Check(client_->Apply("m", batch, params).status());
    const auto stats = client_->GetStats("m");
    std::printf("%zu points, %llu vertices: filled in %.0f ms\n", points_,
                static_cast<unsigned long long>(stats->mesh->stats.vertices),
                Microseconds(Clock::now() - start) / 1000);
  }

  // Of batches without an edit: what the service costs beside the library.
  void Overhead() {
    std::vector<double> trips;
    for (int i = 0; i < 1000; ++i) {
      const auto start = Clock::now();
      Check(client_->Apply("m", {}).status());
      trips.push_back(Microseconds(Clock::now() - start));
    }
    const double rate = StreamBatches(std::vector<EditBatch>(10'000));
    std::printf("empty batches: ApplyEdits p50 %.0f us, p99 %.0f us; EditStream %.0f/s\n",
                Percentile(trips, 0.5), Percentile(trips, 0.99), rate);
  }

  void SingleEdits() {
    std::vector<double> trips, applies;
    for (int i = 0; i < 1000; ++i) {
      const auto start = Clock::now();
      const auto result = client_->Apply("m", {edits_.Next()});
      trips.push_back(Microseconds(Clock::now() - start));
      Check(result.status());
      applies.push_back(result->diff.work.microseconds);
    }
    std::printf(
        "1000 single ApplyEdits: %.0f edits/s; p50 %.0f us, p99 %.0f us; in the library p50 %.0f "
        "us, p99 %.0f us\n",
        1e9 / std::accumulate(trips.begin(), trips.end(), 0.0), Percentile(trips, 0.5),
        Percentile(trips, 0.99), Percentile(applies, 0.5), Percentile(applies, 0.99));
  }

  double StreamEdits(int count, bool with_ids = false) {
    std::vector<EditBatch> batches;
    for (int i = 0; i < count; ++i) batches.push_back({edits_.Next()});
    return StreamBatches(batches, with_ids);
  }

  client::EditParams Params(bool with_id) {
    client::EditParams params;
    if (with_id) params.request_id = "request-" + std::to_string(++requests_);
    return params;
  }

  double StreamBatches(const std::vector<EditBatch>& batches, bool with_ids = false) {
    const auto session = client_->OpenEdits("m");
    const auto start = Clock::now();
    std::thread sender([&] {
      for (const EditBatch& batch : batches) Check(session->Send(batch, Params(with_ids)));
      Check(session->DoneSending());
    });
    while (const auto answer = session->Receive()) Check(answer->result.status());
    sender.join();
    Check(session->Finish());
    return static_cast<double>(batches.size()) / (Microseconds(Clock::now() - start) * 1e-6);
  }

  void Stream() {
    std::vector<double> rates;
    for (int i = 0; i < 9; ++i) rates.push_back(StreamEdits(10'000));
    std::printf("EditStream: %.0f single edits/s (of 9 runs: least %.0f, most %.0f)\n",
                Percentile(rates, 0.5), Percentile(rates, 0), Percentile(rates, 1));
  }

  // More than a journal keeps, so that old ones are taken away.
  void Requests() {
    StreamEdits(12'000, /*with_ids=*/true);
    std::vector<double> trips[2], rates[2];
    for (int i = 0; i < 2'000; ++i) {
      const bool with_id = i % 2 == 1;
      const EditBatch batch = {edits_.Next()};
      const auto start = Clock::now();
      Check(client_->Apply("m", batch, Params(with_id)).status());
      trips[with_id].push_back(Microseconds(Clock::now() - start));
    }
    for (int i = 0; i < 10; ++i) rates[i % 2].push_back(StreamEdits(5'000, i % 2 == 1));
    for (const bool with_id : {false, true}) {
      std::printf("%s request ids: ApplyEdits p50 %.0f us, p99 %.0f us; EditStream %.0f edits/s\n",
                  with_id ? "with" : "without", Percentile(trips[with_id], 0.5),
                  Percentile(trips[with_id], 0.99), Percentile(rates[with_id], 0.5));
    }
  }

  void StreamWithWatchers(int count) {
    std::vector<std::unique_ptr<client::WatchSession>> watches;
    for (int i = 0; i < count; ++i) watches.push_back(client_->Watch("m", {}, nullptr));
    for (const auto& w : watches)
      w->WaitFor([](const auto& r) { return r.has_mesh(); }, absl::Seconds(100));
    const double rate = StreamEdits(2'000);
    const auto start = Clock::now();
    const auto info = client_->GetMesh("m");
    int equal = 0;
    int resyncs = 0;
    for (const auto& w : watches) {
      w->WaitForRevision(info->revision, absl::Seconds(100));
      w->Read([&](const auto& r) { equal += r.hash() == info->hash ? 1 : 0; });
      resyncs += w->resyncs();
    }
    std::printf(
        "EditStream with %d watchers: %.0f edits/s; all caught up %.0f ms after the last; "
        "%d of %d end with the server's hash, %d snapshots after the first\n",
        count, rate, Microseconds(Clock::now() - start) / 1000, equal, count, resyncs);
  }

  double CallEdits(int count) {
    const auto start = Clock::now();
    for (int i = 0; i < count; ++i) Check(client_->Apply("m", {edits_.Next()}).status());
    return count / (Microseconds(Clock::now() - start) * 1e-6);
  }

  // Rates until the last answer, and until every watcher has the last revision.
  void Fanout(const char* name, int edits, const std::function<double(int)>& edit) {
    constexpr int kWatchers = 200, kRuns = 3;
    std::vector<double> answered, received;
    double messages = 0;
    for (int run = 0; run < kRuns; ++run) {
      const auto before = client_->GetMesh("m");
      Check(before.status());
      test::RawWatchers watchers(address_, "m", before->revision, kWatchers);
      if (!watchers.WaitForOpen()) Check(absl::DeadlineExceededError("the watches do not begin"));
      const auto start = Clock::now();
      answered.push_back(edit(edits));
      const auto info = client_->GetMesh("m");
      Check(info.status());
      if (!watchers.WaitFor(info->revision)) {
        Check(absl::DeadlineExceededError("a watcher has not received the last revision"));
      }
      received.push_back(edits / (Microseconds(Clock::now() - start) * 1e-6));
      messages += static_cast<double>(watchers.messages());
    }
    std::printf(
        "%s with %d watchers that hold no mesh: %.0f edits/s answered, %.0f edits/s received by "
        "all; %.2f messages per edit and watcher\n",
        name, kWatchers, Percentile(answered, 0.5), Percentile(received, 0.5),
        messages / kRuns / kWatchers / edits);
  }

  // A watcher that takes a message, then none for 10 s, then the rest.
  void SilentWatcher() {
    const auto stub =
        v1::MeshService::NewStub(grpc::CreateChannel(address_, grpc::InsecureChannelCredentials()));
    grpc::ClientContext context;
    v1::WatchRequest request;
    request.set_mesh("meshes/m");
    const auto reader = stub->Watch(&context, request);
    client::MeshReplica replica;
    v1::WatchEvent event;
    reader->Read(&event);
    Check(replica.Take(event).status());
    const auto start = Clock::now();
    double rate = 0;
    std::uint64_t edits = 0;
    while (Clock::now() - start < std::chrono::seconds(10)) {
      rate += StreamEdits(5'000);
      ++edits;
    }
    const auto info = client_->GetMesh("m");
    int messages = 0;
    int snapshots = 0;
    const auto resumed = Clock::now();
    while (replica.revision() < info->revision ||
           replica.state() != client::MeshReplica::State::kLive) {
      if (!reader->Read(&event)) break;
      const auto change = replica.Take(event);
      Check(change.status());
      ++messages;
      snapshots += std::holds_alternative<client::MeshReplica::NewSnapshot>(*change) ? 1 : 0;
    }
    std::printf(
        "a watcher silent for 10 s: %.0f edits/s beside it; then %d messages and %.0f ms "
        "(%d snapshots) to the end: %s\n",
        rate / static_cast<double>(edits), messages, Microseconds(Clock::now() - resumed) / 1000,
        snapshots, replica.hash() == info->hash ? "equal" : "DIFFERENT");
    context.TryCancel();
    reader->Finish();
  }

  void Snapshot() {
    const auto start = Clock::now();
    const auto mesh = client_->GetSnapshot("m");
    Check(mesh.status());
    std::printf("snapshot of %zu vertices: %.0f ms\n", mesh->vertices.size(),
                Microseconds(Clock::now() - start) / 1000);
  }

  void ManyMeshes() {
    constexpr int kMeshes = 64;
    const std::size_t points = std::max<std::size_t>(points_ / kMeshes, 1);
    for (const int dimension : {2, 3}) {
      const int edits = dimension == 2 ? 1'000 : 20;
      std::vector<double> rates;
      for (int run = 0; run < 3; ++run) {
        const auto rate = test::EditManyMeshes(address_, dimension, kMeshes, points, edits);
        Check(rate.status());
        rates.push_back(*rate);
      }
      std::printf("EditStreams to %d meshes of %zu points in %dD: %.0f single edits/s in all\n",
                  kMeshes, points, dimension, Percentile(rates, 0.5));
    }
  }

  const std::size_t points_;
  std::string address_;
  std::uint64_t requests_ = 0;
  test::RandomEdits edits_{1, 2};
  std::unique_ptr<server::Server> server_;
  std::unique_ptr<client::MeshClient> client_;
};

}  // namespace
}  // namespace dynmesh

namespace {

int Refuse(const std::string& what) {
  std::fprintf(stderr, "service_load: %s\nservice_load --help tells what there is\n", what.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  using dynmesh::kMostPoints;
  using dynmesh::kParts;
  if (!dynmesh::server::SetLogLevel("error").ok()) return 1;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // figures are seen as they come
  std::vector<std::string> words(argv + 1, argv + argc);
  std::string address, data_dir;
  std::size_t points = 20'000;
  const std::string server = "--server=", data = "--data-dir=";
  if (!words.empty() && words[0] == "--help") return std::fputs(dynmesh::kHelp, stdout) < 0 ? 1 : 0;
  if (!words.empty() && words[0].starts_with(server)) {
    address = words[0].substr(server.size());
    if (address.empty()) return Refuse("--server= is without an address");
    words.erase(words.begin());
  }
  if (!words.empty() && words[0].starts_with(data)) {
    data_dir = words[0].substr(data.size());
    if (data_dir.empty()) return Refuse("--data-dir= is without a folder");
    if (!address.empty()) return Refuse("--data-dir is of the server in this process");
    words.erase(words.begin());
  }
  if (!words.empty()) {
    const std::string& word = words[0];
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), points);
    if (error != std::errc() || end != word.data() + word.size() || points == 0 ||
        points > kMostPoints) {
      return Refuse("'" + word + "' is no number of points from 1 to " +
                    std::to_string(kMostPoints));
    }
    words.erase(words.begin());
  }
  for (const std::string& part : words) {
    if (std::find(kParts.begin(), kParts.end(), part) == kParts.end()) {
      return Refuse("'" + part + "' is no part");
    }
  }
  dynmesh::Load(points, address, data_dir).Run(words);
}
