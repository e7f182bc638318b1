// The streams of clients that are open, so that a drain can end them, and those whose client is
// there but does not say which mesh it means, or leaves a batch unfinished, for what it has sent
// of it takes room. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
#define DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_

#include <atomic>
#include <chrono>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace dynmesh::server {

class OpenStream {
 public:
  using Clock = std::chrono::steady_clock;

  virtual ~OpenStream() = default;
  // Answers what was received whole, then ends the stream. From any thread.
  virtual void End(const absl::Status& status) = 0;

  // True if it waits for its first message, or for more of a batch, since `time` or longer.
  bool WaitsSince(Clock::time_point time) const {
    return waits_since_.load(std::memory_order_relaxed) <= time.time_since_epoch().count();
  }

 protected:
  // The reader's: the client is waited for, from now on or, if what it sent last brought nothing,
  // from when it was before.
  void SetWaits(bool anew) {
    if (anew) since_ = Clock::now().time_since_epoch().count();
    waits_since_.store(since_, std::memory_order_relaxed);
  }
  void SetWaitsNot() { waits_since_.store(kNever, std::memory_order_relaxed); }

 private:
  static constexpr Clock::rep kNever = std::numeric_limits<Clock::rep>::max();
  Clock::rep since_ = kNever;
  std::atomic<Clock::rep> waits_since_ = kNever;
};

class OpenStreams {
 public:
  void Add(const std::shared_ptr<OpenStream>& stream) {
    const std::lock_guard lock(mutex_);
    if (streams_.size() >= clean_at_) {
      std::erase_if(streams_, [](const auto& weak) { return weak.expired(); });
      clean_at_ = 2 * streams_.size() + 64;
    }
    streams_.push_back(stream);
  }
  void EndAll(const absl::Status& status) {
    std::vector<std::weak_ptr<OpenStream>> streams;
    {
      const std::lock_guard lock(mutex_);
      streams.swap(streams_);
    }
    for (const auto& weak : streams) {
      if (const auto stream = weak.lock()) stream->End(status);
    }
  }
  // Those that wait for so long.
  void EndWaiting(OpenStream::Clock::duration limit, const absl::Status& status) {
    const auto since = OpenStream::Clock::now() - limit;
    std::vector<std::shared_ptr<OpenStream>> waiting;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& weak : streams_) {
        if (auto stream = weak.lock(); stream != nullptr && stream->WaitsSince(since)) {
          waiting.push_back(std::move(stream));
        }
      }
    }
    for (const auto& stream : waiting) stream->End(status);
  }

 private:
  std::mutex mutex_;
  std::vector<std::weak_ptr<OpenStream>> streams_;
  std::size_t clean_at_ = 64;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
