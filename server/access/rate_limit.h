// Limits the request rate of each client with a token bucket per client. Thread-safe; a request
// costs a lock of the client's bucket.
#ifndef DYNMESH_SERVER_ACCESS_RATE_LIMIT_H_
#define DYNMESH_SERVER_ACCESS_RATE_LIMIT_H_

#include <cstddef>
#include <memory>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class RateBucket {
 public:
  // Capacity: the requests of one second, at least 1. Full at first.
  RateBucket(double per_second, absl::Time now);

  // Zero: taken. Else the time until the next is available, unless another request takes it.
  absl::Duration Take(absl::Time now);
  bool IsFull(absl::Time now);

 private:
  void FillLocked(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const double per_second_;
  const double most_;
  Mutex mutex_;
  double left_ ABSL_GUARDED_BY(mutex_);
  absl::Time filled_ ABSL_GUARDED_BY(mutex_);
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
  mutable Mutex mutex_;
  absl::flat_hash_map<std::string, std::shared_ptr<RateBucket>> buckets_ ABSL_GUARDED_BY(mutex_);
  // Number of buckets at which full ones are removed.
  std::size_t sweep_at_ ABSL_GUARDED_BY(mutex_) = 1024;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_RATE_LIMIT_H_
