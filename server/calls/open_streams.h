// The streams of clients that are open, so that a drain can end them. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
#define DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace dynmesh::server {

class OpenStream {
 public:
  virtual ~OpenStream() = default;
  // Answers what was received whole, then ends the stream. From any thread.
  virtual void End(const absl::Status& status) = 0;
};

class OpenStreams {
 public:
  void Add(const std::shared_ptr<OpenStream>& stream) {
    const std::lock_guard lock(mutex_);
    std::erase_if(streams_, [](const auto& weak) { return weak.expired(); });
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

 private:
  std::mutex mutex_;
  std::vector<std::weak_ptr<OpenStream>> streams_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_OPEN_STREAMS_H_
