#include "tests/e2e/soak/audience.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>

#include "client/cli/percentile.h"

namespace dynmesh::soak {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kChannels = 3;  // and one for the slow

}  // namespace

Audience::Audience(const Plan& plan, std::vector<std::string> meshes, Faults* faults)
    : plan_(plan), meshes_(std::move(meshes)), faults_(faults) {}

Audience::~Audience() {
  for (const auto& w : watchers_) w->Abandon();
  for (std::thread& thread : threads_) thread.join();
}

void Audience::Start(const std::string& address, const std::string& authority,
                     client::MeshClient& client) {
  for (int i = 0; i <= kChannels; ++i) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    if (i == kChannels) {
      // By default gRPC buffers megabytes, so that the server would not notice a slow client for
      // hours.
      arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
      arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 16 << 10);
    }
    channels_.push_back(
        grpc::CreateCustomChannel(address, grpc::SslCredentials({authority, "", ""}), arguments));
  }
  const int meshes = static_cast<int>(meshes_.size());
  for (int i = 0; i < plan_.watchers; ++i) {
    Watcher::Config config;
    config.mesh = meshes_[static_cast<std::size_t>(i % meshes)];
    const int beyond_slow = i - plan_.slow;
    const int beyond_restless = beyond_slow - plan_.restless;
    if (beyond_restless >= 0 && beyond_restless < plan_.sessions) {
      sessions_.push_back(std::make_unique<SessionWatcher>(config.mesh, client, &counts_, faults_));
      continue;
    }
    config.manner = beyond_slow < 0       ? Watcher::Manner::kSlow
                    : beyond_restless < 0 ? Watcher::Manner::kRestless
                                          : Watcher::Manner::kSteady;
    // One slow and one restless watcher of each mesh has a replica.
    config.replica = i < meshes || (beyond_slow >= 0 && beyond_slow < meshes);
    config.nap = absl::Seconds(plan_.nap_seconds);
    config.seed = plan_.seed + static_cast<std::uint64_t>(i);
    const int channel = beyond_slow < 0 ? kChannels : i / meshes % kChannels;
    watchers_.push_back(std::make_unique<Watcher>(
        config, channels_[static_cast<std::size_t>(channel)], &counts_, faults_));
    threads_.emplace_back([w = watchers_.back().get()] { w->Run(); });
  }
}

void Audience::Close(std::span<const MeshHead> heads, double seconds) {
  const auto head_of = [&](const std::string& mesh) { return heads[IndexOf(mesh)]; };
  const auto deadline = Clock::now() + std::chrono::milliseconds(static_cast<int>(1000 * seconds));
  for (const auto& w : watchers_) w->Close(head_of(w->config().mesh).revision);
  for (const auto& w : watchers_) {
    while (w->revision() < head_of(w->config().mesh).revision && Clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  for (const auto& s : sessions_) {
    const MeshHead head = head_of(s->mesh());
    const absl::Duration left = absl::FromChrono(deadline - Clock::now());
    at_end_ += s->WaitFor(head.revision, head.hash, std::max(left, absl::Seconds(1))) ? 1 : 0;
  }
  if (Clock::now() >= deadline) {
    for (const auto& w : watchers_) w->Abandon();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  for (const auto& w : watchers_) {
    const MeshHead head = head_of(w->config().mesh);
    at_end_ += w->Has(head.revision, head.hash.ToHex()) ? 1 : 0;
  }
  for (const auto& s : sessions_) s->Stop();
}

Audience::Report Audience::ReportOf(std::span<const MeshHead> heads) const {
  // Watchers may be ahead of the writers' last answers.
  const auto lag = [&](const std::string& mesh, std::uint64_t revision) {
    const std::uint64_t head = heads[IndexOf(mesh)].revision;
    return head < revision ? 0 : static_cast<double>(head - revision);
  };
  std::vector<double> steady, slow;
  for (const auto& w : watchers_) {
    const double behind = lag(w->config().mesh, w->revision());
    if (w->config().manner == Watcher::Manner::kSteady) steady.push_back(behind);
    if (w->config().manner == Watcher::Manner::kSlow) slow.push_back(behind);
  }
  for (const auto& s : sessions_) steady.push_back(lag(s->mesh(), s->revision()));
  Report report;
  report.lag_steady_max = cli::Percentile(steady, 1);
  report.lag_slow_p50 = cli::Percentile(slow, 0.5);
  report.lag_slow_max = cli::Percentile(slow, 1);
  report.revisions = counts_.revisions;
  report.coalesced = counts_.coalesced;
  report.resyncs = counts_.resyncs;
  report.reconnects = counts_.reconnects;
  report.compacted = counts_.compacted;
  report.broken = counts_.broken;
  report.lost = counts_.lost;
  report.doubled = counts_.doubled;
  report.damaged = counts_.damaged;
  report.watchers = watchers_.size() + sessions_.size();
  report.at_end = at_end_;
  report.faults = faults_->count();
  return report;
}

std::size_t Audience::IndexOf(const std::string& mesh) const {
  return static_cast<std::size_t>(std::ranges::find(meshes_, mesh) - meshes_.begin());
}

}  // namespace dynmesh::soak
