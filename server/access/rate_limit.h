// How many requests each client may make: a bucket a client, that fills at a constant rate and
// from which each request takes one. Thread-safe; a request costs a lock of its own bucket.
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
  // Holds what comes in a second, one at least, and is full at first.
  RateBucket(double per_second, absl::Time now);

  // Zero: taken. Else when there will be one, if nobody else takes it.
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
  // 0: any number, and no buckets. Of more than `max_clients` that are not at rest, those that
  // came late share one: memory is bounded, whoever calls.
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
  std::size_t sweep_at_ = 1024;  // buckets at which those that are full are forgotten
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_RATE_LIMIT_H_
