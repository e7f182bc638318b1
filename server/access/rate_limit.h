// Limits the request rate of each client with a token bucket per client. Thread-safe; a request
// costs a lock of the client's bucket.
#ifndef DYNMESH_SERVER_ACCESS_RATE_LIMIT_H_
#define DYNMESH_SERVER_ACCESS_RATE_LIMIT_H_

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace dynmesh::server {

class RateBucket {
 public:
  // Capacity: the requests of one second, at least 1. Full at first.
  RateBucket(double per_second, absl::Time now);

  // Zero: taken. Else the time until the next is available, unless another request takes it.
  absl::Duration Take(absl::Time now);
  bool IsFull(absl::Time now);

 private:
  void FillLocked(absl::Time now);

  const double per_second_;
  const double most_;
  std::mutex mutex_;
  double left_;
  absl::Time filled_;
};

class RateLimit {
 public:
  // `per_second` 0: no limit and no buckets. Beyond `max_clients` active clients, new ones share
  // one bucket, which bounds the memory.
  explicit RateLimit(double per_second, std::size_t max_clients = 100'000)
      : per_second_(per_second), max_clients_(max_clients) {}

  // Null if there is no limit.
  std::shared_ptr<RateBucket> BucketOf(absl::string_view client, absl::Time now);
  std::size_t clients() const;

 private:
  const double per_second_;
  const std::size_t max_clients_;
  mutable std::mutex mutex_;
  absl::flat_hash_map<std::string, std::shared_ptr<RateBucket>> buckets_;
  std::size_t sweep_at_ = 1024;  // number of buckets at which full ones are removed
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_RATE_LIMIT_H_
