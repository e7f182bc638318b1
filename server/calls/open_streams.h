// The clients' open streams and edits. A drain ends them: first it lets them answer what they have
// received, then it cancels the rest, then it cuts the calls. A stream is also ended if its client
// does not name its mesh or leaves a batch unfinished, since the received part takes memory.
// Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
#define DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_

#include <grpcpp/server_context.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "server/calls/cut_call.h"

namespace dynmesh::server {

class OpenStream {
 public:
  using Clock = std::chrono::steady_clock;

  virtual ~OpenStream() = default;
  // Answers the completely received batches, then ends the stream. From any thread.
  virtual void End(const absl::Status& status) = 0;
  // Undoes the batches that are not done, and answers them with `status`. From any thread.
  virtual void Cancel(const absl::Status& /*status*/) {}
  // Ends the call with UNAVAILABLE and `why`, and waits for nothing. From any thread.
  void Cut(const std::string& why) {
    const MutexLock lock(rpc_mutex_);
    if (open_rpc_ != nullptr) CutCall(*open_rpc_, GRPC_STATUS_UNAVAILABLE, why);
  }

  // True if it has waited for its first message, or for more of a batch, since `time` or longer.
  bool WaitsSince(Clock::time_point time) const {
    return waits_since_.load(std::memory_order_relaxed) <= time.time_since_epoch().count();
  }

 protected:
  // Once, before it is added to the streams; Leave: in OnDone.
  void Enter(grpc::CallbackServerContext* rpc) {
    const MutexLock lock(rpc_mutex_);
    open_rpc_ = rpc;
  }
  void Leave() {
    const MutexLock lock(rpc_mutex_);
    open_rpc_ = nullptr;
  }

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

  Mutex rpc_mutex_;
  grpc::CallbackServerContext* open_rpc_ ABSL_GUARDED_BY(rpc_mutex_) = nullptr;
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
    for (const auto& stream : All()) stream->End(status);
  }
  void CancelAll(const absl::Status& status) {
    for (const auto& stream : All()) stream->Cancel(status);
  }
  void CutAll(const std::string& why) {
    for (const auto& stream : All()) stream->Cut(why);
  }
  // Ends the streams that have waited for `limit`.
  void EndWaiting(OpenStream::Clock::duration limit, const absl::Status& status) {
    const auto since = OpenStream::Clock::now() - limit;
    for (const auto& stream : All()) {
      if (stream->WaitsSince(since)) stream->End(status);
    }
  }

 private:
  std::vector<std::shared_ptr<OpenStream>> All() {
    std::vector<std::shared_ptr<OpenStream>> all;
    const MutexLock lock(mutex_);
    all.reserve(streams_.size());
    for (const auto& weak : streams_) {
      if (auto stream = weak.lock()) all.push_back(std::move(stream));
    }
    return all;
  }

  Mutex mutex_;
  std::vector<std::weak_ptr<OpenStream>> streams_ ABSL_GUARDED_BY(mutex_);
  std::size_t clean_at_ ABSL_GUARDED_BY(mutex_) = 64;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
