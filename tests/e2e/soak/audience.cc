#include "tests/e2e/soak/audience.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "client/cli/percentile.h"

namespace dynmesh::soak {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kChannels = 3;  // and one for the slow

}  // namespace

Audience::Audience(const Plan& plan, std::deque<Site>* sites, Faults* faults)
    : plan_(plan), sites_(sites), faults_(faults) {}

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
      // By default gRPC lets megabytes wait on the way: the server would hear of nothing for hours.
      arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
      arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 16 << 10);
    }
    channels_.push_back(
        grpc::CreateCustomChannel(address, grpc::SslCredentials({authority, "", ""}), arguments));
  }
  const int meshes = static_cast<int>(sites_->size());
  for (int i = 0; i < plan_.watchers; ++i) {
    Watcher::Config config;
    config.mesh = (*sites_)[static_cast<std::size_t>(i % meshes)].plan.name;
    const int beyond_slow = i - plan_.slow;
    const int beyond_restless = beyond_slow - plan_.restless;
    if (beyond_restless >= 0 && beyond_restless < plan_.sessions) {
      sessions_.push_back(std::make_unique<SessionWatcher>(config.mesh, client, &counts_, faults_));
      continue;
    }
    config.manner = beyond_slow < 0       ? Watcher::Manner::kSlow
                    : beyond_restless < 0 ? Watcher::Manner::kRestless
                                          : Watcher::Manner::kSteady;
    // Of the slow and of the restless one for each mesh holds it.
    config.replica = i < meshes || (beyond_slow >= 0 && beyond_slow < meshes);
    config.nap = absl::Seconds(plan_.nap_seconds);
    config.seed = plan_.seed + static_cast<std::uint64_t>(i);
    const int channel = beyond_slow < 0 ? kChannels : i / meshes % kChannels;
    watchers_.push_back(std::make_unique<Watcher>(
        config, channels_[static_cast<std::size_t>(channel)], &counts_, faults_));
    threads_.emplace_back([w = watchers_.back().get()] { w->Run(); });
  }
}

void Audience::Close(double seconds) {
  const auto deadline = Clock::now() + std::chrono::milliseconds(static_cast<int>(1000 * seconds));
  for (const auto& w : watchers_) w->Close(SiteOf(w->config().mesh).head);
  for (const auto& w : watchers_) {
    while (w->revision() < SiteOf(w->config().mesh).head && Clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  for (const auto& s : sessions_) {
    const Site& site = SiteOf(s->mesh());
    const absl::Duration left = absl::FromChrono(deadline - Clock::now());
    at_end_ += s->WaitFor(site.head, site.hash, std::max(left, absl::Seconds(1))) ? 1 : 0;
  }
  if (Clock::now() >= deadline) {
    for (const auto& w : watchers_) w->Abandon();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  for (const auto& w : watchers_) {
    const Site& site = SiteOf(w->config().mesh);
    at_end_ += w->Has(site.head, site.hash.ToHex()) ? 1 : 0;
  }
  for (const auto& s : sessions_) s->Stop();
}

cli::JsonObject Audience::Report() const {
  std::vector<double> steady, slow;
  for (const auto& w : watchers_) {
    const double lag = Lag(w->config().mesh, w->revision());
    if (w->config().manner == Watcher::Manner::kSteady) steady.push_back(lag);
    if (w->config().manner == Watcher::Manner::kSlow) slow.push_back(lag);
  }
  for (const auto& s : sessions_) steady.push_back(Lag(s->mesh(), s->revision()));
  cli::JsonObject report;
  report.Add("lag_steady_max", cli::Percentile(steady, 1));
  report.Add("lag_slow_p50", cli::Percentile(slow, 0.5));
  report.Add("lag_slow_max", cli::Percentile(slow, 1));
  report.Add("revisions", counts_.revisions.load());
  report.Add("coalesced", counts_.coalesced.load());
  report.Add("resyncs", counts_.resyncs.load());
  report.Add("reconnects", counts_.reconnects.load());
  report.Add("compacted", counts_.compacted.load());
  report.Add("broken", counts_.broken.load());
  return report;
}

// Revisions behind the last that a writer was told of.
double Audience::Lag(const std::string& mesh, std::uint64_t revision) const {
  const std::uint64_t head = SiteOf(mesh).ledger.head();
  return head < revision ? 0 : static_cast<double>(head - revision);
}

const Site& Audience::SiteOf(const std::string& mesh) const {
  for (const Site& site : *sites_) {
    if (site.plan.name == mesh) return site;
  }
  std::abort();
}

}  // namespace dynmesh::soak
