// The part of MeshRegistry that makes revisions again which a mesh does not hold any more.
#include <chrono>
#include <utility>

#include "server/meshes/mesh_registry.h"
#include "server/meshes/recovery.h"
#include "server/revisions/revision_error.h"

namespace dynmesh::server {
namespace {

// A watcher that asks for more is as quick with a snapshot.
constexpr std::chrono::seconds kLongestPast(30);
constexpr int kMostPasts = 16;

}  // namespace

void MeshRegistry::MakePast(const HostPtr& host, const WatchHub::Start& start,
                            std::shared_ptr<const std::atomic<bool>> cancelled,
                            std::function<void(absl::StatusOr<Past>)> done) {
  if (host->history() == nullptr) return done(absl::OutOfRangeError("there is no journal"));
  if (++pasts_ > kMostPasts) {
    --pasts_;
    return done(absl::ResourceExhaustedError("too many watches begin in the past"));
  }
  past_pool_.Post([this, host, start, cancelled = std::move(cancelled), done = std::move(done)] {
    absl::StatusOr<Past> past = PastOf(*host, start, *cancelled);
    --pasts_;
    done(std::move(past));
  });
}

absl::StatusOr<MeshRegistry::Past> MeshRegistry::PastOf(const MeshHost& host,
                                                        const WatchHub::Start& start,
                                                        const std::atomic<bool>& cancelled) const {
  const std::uint64_t from = *start.revision;
  const Head head = host.head();
  if (from >= head.revision || head.revision - from > config_.history_revisions) {
    return absl::OutOfRangeError("more revisions than are kept");
  }
  if (memory_ != nullptr) {
    if (absl::Status s = memory_->CheckRoom(); !s.ok()) return s;
  }
  const auto end = std::chrono::steady_clock::now() + kLongestPast;
  int calls = 0;
  const auto interrupted = [&] {
    if (cancelled.load(std::memory_order_relaxed) || ends_.load(std::memory_order_relaxed)) {
      return true;
    }
    return ++calls % 1'000 == 0 && std::chrono::steady_clock::now() > end;
  };
  const auto store = ReadPast(host.history()->journal(), host.history()->key(), host.mesh_options(),
                              factory_, HostOptions(), from, head.revision, interrupted);
  if (!store.ok()) {
    const bool is_late = absl::IsCancelled(store.status()) && !cancelled && !ends_;
    return is_late ? absl::OutOfRangeError("making the revisions takes too long") : store.status();
  }
  auto diffs = (*store)->DiffsFrom(from);
  const std::optional<MeshHash> hash = (*store)->HashAt(from);
  if (!hash.has_value() || !diffs.has_value() || diffs->empty()) {
    return absl::OutOfRangeError("more bytes of diffs than are kept");
  }
  if (start.hash.value_or(*hash) != *hash) {
    return DivergedRevision(from, *hash, *start.hash, head, host.store()->oldest(), kWatchWithout);
  }
  return *std::move(diffs);
}

}  // namespace dynmesh::server
