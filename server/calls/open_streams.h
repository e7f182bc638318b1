// The clients' open streams. A drain ends them. A stream is also ended if its client does not name
// its mesh or leaves a batch unfinished, since the received part takes memory. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
#define DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_

#include <atomic>
#include <chrono>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class OpenStream {
 public:
  using Clock = std::chrono::steady_clock;

  virtual ~OpenStream() = default;
  // Answers the completely received batches, then ends the stream. From any thread.
  virtual void End(const absl::Status& status) = 0;

  // True if it has waited for its first message, or for more of a batch, since `time` or longer.
  bool WaitsSince(Clock::time_point time) const {
    return waits_since_.load(std::memory_order_relaxed) <= time.time_since_epoch().count();
  }

 protected:
  // By the reader: begins to wait for the client. With `anew` the wait counts from now. Without it
  // (the last message added nothing) from the last time with `anew`.
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
    const MutexLock lock(mutex_);
    if (streams_.size() >= clean_at_) {
      std::erase_if(streams_, [](const auto& weak) { return weak.expired(); });
      clean_at_ = 2 * streams_.size() + 64;
    }
    streams_.push_back(stream);
  }
  void EndAll(const absl::Status& status) {
    std::vector<std::weak_ptr<OpenStream>> streams;
    {
      const MutexLock lock(mutex_);
      streams.swap(streams_);
    }
    for (const auto& weak : streams) {
      if (const auto stream = weak.lock()) stream->End(status);
    }
  }
  // Ends the streams that have waited for `limit`.
  void EndWaiting(OpenStream::Clock::duration limit, const absl::Status& status) {
    const auto since = OpenStream::Clock::now() - limit;
    std::vector<std::shared_ptr<OpenStream>> waiting;
    {
      const MutexLock lock(mutex_);
      for (const auto& weak : streams_) {
        if (auto stream = weak.lock(); stream != nullptr && stream->WaitsSince(since)) {
          waiting.push_back(std::move(stream));
        }
      }
    }
    for (const auto& stream : waiting) stream->End(status);
  }

 private:
  Mutex mutex_;
  std::vector<std::weak_ptr<OpenStream>> streams_ ABSL_GUARDED_BY(mutex_);
  std::size_t clean_at_ ABSL_GUARDED_BY(mutex_) = 64;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
