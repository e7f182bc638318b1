// The events of diffs as bytes, encoded once for all watches that send the same diff. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_SHARED_EVENTS_H_
#define DYNMESH_SERVER_CALLS_SHARED_EVENTS_H_

#include <grpcpp/support/byte_buffer.h>

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/mutex.h"
#include "dynmesh/mesh.h"
#include "dynmesh/v1/mesh_service.pb.h"

namespace dynmesh::server {

// The message as bytes.
grpc::ByteBuffer EncodeEvent(const v1::WatchEvent& event);

class SharedEvents {
 public:
  // The messages of one diff, in order; at least one. Copies of them share the bytes.
  using Events = std::vector<grpc::ByteBuffer>;

  // Keeps about `bytes` of the messages asked for last. A diff of more than `most_messages` is not
  // kept: each watch encodes it message by message, so that a slow one holds one of them.
  explicit SharedEvents(std::size_t bytes = 8 << 20, std::size_t most_messages = 4)
      : bytes_(bytes), most_messages_(most_messages) {}
  SharedEvents(const SharedEvents&) = delete;
  SharedEvents& operator=(const SharedEvents&) = delete;

  // The messages of `diff`, with `fragment_bytes` as DiffFragmenter has it, always the same.
  // Encodes them if they are not kept; threads that ask at the same time wait for one. Null if the
  // diff is too large.
  std::shared_ptr<const Events> Find(const std::shared_ptr<const MeshDiff>& diff,
                                     std::size_t fragment_bytes);

  std::size_t encoded() const;  // diffs looked at so far
  std::size_t held_bytes() const;

 private:
  struct Entry {
    std::once_flag once;
    Events events;
    std::size_t bytes = 0;  // with the mutex
  };
  struct Kept {
    std::weak_ptr<const MeshDiff>
        diff;  // keeps the address from being used again: diffs come from make_shared
    std::shared_ptr<Entry> entry;
  };

  void Encode(const std::shared_ptr<const MeshDiff>& diff, std::size_t fragment_bytes,
              Entry& entry);
  void Trim() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::size_t bytes_, most_messages_;
  mutable Mutex mutex_;
  absl::flat_hash_map<const MeshDiff*, Kept> kept_ ABSL_GUARDED_BY(mutex_);
  std::deque<const MeshDiff*> order_ ABSL_GUARDED_BY(mutex_);  // oldest first
  std::size_t held_ ABSL_GUARDED_BY(mutex_) = 0;
  std::size_t encoded_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_SHARED_EVENTS_H_
