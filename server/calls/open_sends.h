// The calls that are sending. A call is ended if its client takes no message, since it holds a
// place among the streams and perhaps an old mesh for no use. Keepalive does not detect this: the
// client's gRPC answers pings even if the application does not read. Does not depend on gRPC.
// Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_OPEN_SENDS_H_
#define DYNMESH_SERVER_CALLS_OPEN_SENDS_H_

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class OpenSends {
 public:
  using Clock = std::chrono::steady_clock;

  // The messages of one call. Used by the thread that drives the call's writes.
  class Sender {
   public:
    Sender() = default;
    Sender(const Sender&) = delete;
    Sender& operator=(const Sender&) = delete;
    ~Sender() { Leave(); }

    // `end` is called once if a message takes too long to send; not after Leave.
    void Enter(OpenSends& sends, std::function<void()> end) {
      Leave();
      sends_ = &sends;
      end_ = std::move(end);
      const MutexLock lock(sends_->mutex_);
      sends_->senders_.insert(this);
    }
    void Leave() {
      if (sends_ == nullptr) return;
      const MutexLock lock(sends_->mutex_);
      sends_->senders_.erase(this);
      sends_ = nullptr;
    }

    // Begin: a message is handed to gRPC. Done: the client has taken it, or enough to make room for
    // the next. gRPC orders the memory accesses between both, which thread checkers do not see.
    void Begin(Clock::time_point now = Clock::now()) {
      since_.store(now.time_since_epoch().count(), std::memory_order_release);
    }
    void Done() { since_.exchange(kNever, std::memory_order_acquire); }

    // `end` was called.
    bool ended() const { return ended_.load(std::memory_order_relaxed); }

   private:
    friend class OpenSends;
    static constexpr Clock::rep kNever = std::numeric_limits<Clock::rep>::max();

    OpenSends* sends_ = nullptr;
    std::function<void()> end_;
    std::atomic<Clock::rep> since_ = kNever;
    std::atomic<bool> ended_ = false;
  };

  // Ends the calls with a message that has been sending since `time` or longer.
  void EndSlow(Clock::time_point time) {
    const MutexLock lock(mutex_);
    for (Sender* const sender : senders_) {
      if (sender->since_.load(std::memory_order_relaxed) > time.time_since_epoch().count())
        continue;
      // Under the lock, so that the call still exists.
      if (!sender->ended_.exchange(true)) sender->end_();
    }
  }

 private:
  Mutex mutex_;
  absl::flat_hash_set<Sender*> senders_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_OPEN_SENDS_H_
