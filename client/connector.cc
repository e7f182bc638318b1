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
    const MutexLock lock(mutex_);
    stopping_ = true;
  }
  wake_.NotifyAll();
  if (thread_.joinable()) thread_.join();
}

void Connector::Reach(const std::shared_ptr<grpc::Channel>& channel) {
  // The server itself, or one in between, says that it is not available.
  if (channel->GetState(false) == GRPC_CHANNEL_READY) return;
  const Clock::time_point now = Clock::now();
  const MutexLock lock(mutex_);
  auto target = targets_.find(channel.get());
  if (target == targets_.end()) {
    target =
        targets_.emplace(channel.get(), Target{channel, Backoff(kFirst, kLongest), {}, {}}).first;
    target->second.next = now + absl::ToChronoNanoseconds(target->second.backoff.Failed());
  }
  target->second.wanted = now + kWanted;
  if (!thread_.joinable()) thread_ = std::thread([this] { Run(); });
  wake_.NotifyAll();
}

void Connector::Pause(absl::Duration limit) {
  const MutexLock lock(mutex_);
  counted_.WaitFor(mutex_, absl::ToChronoNanoseconds(std::min(limit, absl::Hours(1))),
                   [this, before = count_]()
                       ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return count_ != before; });
}

std::uint64_t Connector::reached() {
  const MutexLock lock(mutex_);
  return count_;
}

void Connector::Listen(const void* owner, std::function<void()> reached) {
  const MutexLock lock(listeners_mutex_);
  listeners_[owner] = std::move(reached);
}

void Connector::Unlisten(const void* owner) {
  const MutexLock lock(listeners_mutex_);
  listeners_.erase(owner);
}

void Connector::Run() {
  grpc::CompletionQueue changes;
  void* changed = nullptr;
  bool in_time = false;
  MutexLock lock(mutex_);
  wake_.WaitFor(mutex_, kGrace,
                [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_; });
  while (!stopping_) {
    if (targets_.empty()) {
      wake_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return stopping_ || !targets_.empty();
      });
      continue;
    }
    if (Step(changes)) {
      ++count_;
      counted_.NotifyAll();
      lock.Unlock();
      {
        const MutexLock listening(listeners_mutex_);
        for (const auto& [owner, listener] : listeners_) listener();
      }
      lock.Lock();
    }
    if (targets_.empty()) continue;
    lock.Unlock();
    changes.Next(&changed, &in_time);  // all targets are watched, for a slice at most
    lock.Lock();
    static_cast<Target*>(changed)->is_watched = false;
  }
  lock.Unlock();
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
