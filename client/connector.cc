#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "client/connector_internal.h"

namespace dynmesh::client {
namespace {

constexpr absl::Duration kFirst = absl::Milliseconds(100), kLongest = absl::Seconds(5);
constexpr std::chrono::seconds kWanted(30);
// The connector looks at all servers as often, and a client that goes waits as long at most.
constexpr std::chrono::milliseconds kSlice(100);
// A program that ends with the first error does not wait for the connector.
constexpr std::chrono::milliseconds kGrace(20);

}  // namespace

Connector::~Connector() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Connector::Reach(const std::shared_ptr<grpc::Channel>& channel) {
  // The server itself, or one in between, says that it is not available.
  if (channel->GetState(false) == GRPC_CHANNEL_READY) return;
  const Clock::time_point now = Clock::now();
  const std::lock_guard lock(mutex_);
  auto target = targets_.find(channel.get());
  if (target == targets_.end()) {
    target =
        targets_.emplace(channel.get(), Target{channel, Backoff(kFirst, kLongest), {}, {}}).first;
    target->second.next = now + absl::ToChronoNanoseconds(target->second.backoff.Failed());
  }
  target->second.wanted = now + kWanted;
  if (!thread_.joinable()) thread_ = std::thread([this] { Run(); });
  wake_.notify_all();
}

void Connector::Pause(absl::Duration limit) {
  std::unique_lock lock(mutex_);
  counted_.wait_for(lock, absl::ToChronoNanoseconds(std::min(limit, absl::Hours(1))),
                    [this, before = count_] { return count_ != before; });
}

std::uint64_t Connector::reached() {
  const std::lock_guard lock(mutex_);
  return count_;
}

void Connector::Listen(const void* owner, std::function<void()> reached) {
  const std::lock_guard lock(listeners_mutex_);
  listeners_[owner] = std::move(reached);
}

void Connector::Unlisten(const void* owner) {
  const std::lock_guard lock(listeners_mutex_);
  listeners_.erase(owner);
}

void Connector::Run() {
  grpc::CompletionQueue changes;
  void* changed = nullptr;
  bool in_time = false;
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, kGrace, [this] { return stopping_; });
  while (!stopping_) {
    if (targets_.empty()) {
      wake_.wait(lock, [this] { return stopping_ || !targets_.empty(); });
      continue;
    }
    if (Step(changes)) {
      ++count_;
      counted_.notify_all();
      lock.unlock();
      {
        const std::lock_guard listening(listeners_mutex_);
        for (const auto& [owner, listener] : listeners_) listener();
      }
      lock.lock();
    }
    if (targets_.empty()) continue;
    lock.unlock();
    changes.Next(&changed, &in_time);  // all targets are watched, for a slice at most
    lock.lock();
    static_cast<Target*>(changed)->is_watched = false;
  }
  lock.unlock();
  changes.Shutdown();
  while (changes.Next(&changed, &in_time)) {
  }
}

bool Connector::Step(grpc::CompletionQueue& changes) {
  bool reached = false;
  for (auto it = targets_.begin(); it != targets_.end();) {
    const bool over = !it->second.is_watched && Advance(it->second, &reached, changes);
    it = over ? targets_.erase(it) : std::next(it);
  }
  return reached;
}

bool Connector::Advance(Target& target, bool* reached, grpc::CompletionQueue& changes) const {
  const Clock::time_point now = Clock::now();
  grpc_connectivity_state state = target.channel->GetState(true);
  if (state == GRPC_CHANNEL_READY) {
    // Otherwise only the connection was lost, not the server: a watch that fails with each
    // connection is to pause.
    *reached = *reached || target.has_failed;
    return true;
  }
  if (state == GRPC_CHANNEL_SHUTDOWN || now >= target.wanted) return true;
  if (state == GRPC_CHANNEL_TRANSIENT_FAILURE) target.has_failed = true;
  if (now >= target.next) {
    grpc::experimental::ChannelResetConnectionBackoff(target.channel.get());
    state = target.channel->GetState(true);
    target.next = now + absl::ToChronoNanoseconds(target.backoff.Failed());
  }
  const auto wait =
      std::clamp<Clock::duration>(target.next - now, std::chrono::milliseconds(1), kSlice);
  target.channel->NotifyOnStateChange(state, std::chrono::system_clock::now() + wait, &changes,
                                      &target);
  target.is_watched = true;
  return false;
}

}  // namespace dynmesh::client
