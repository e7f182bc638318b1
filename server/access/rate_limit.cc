#include "server/access/rate_limit.h"

#include <algorithm>

namespace dynmesh::server {
namespace {

constexpr char kLatecomers[] = "";  // not a client's name

}  // namespace

RateBucket::RateBucket(double per_second, absl::Time now)
    : per_second_(per_second), most_(std::max(1.0, per_second)), left_(most_), filled_(now) {}

void RateBucket::FillLocked(absl::Time now) {
  if (now <= filled_) return;  // the clock was set back
  left_ = std::min(most_, left_ + per_second_ * absl::ToDoubleSeconds(now - filled_));
  filled_ = now;
}

absl::Duration RateBucket::Take(absl::Time now) {
  const MutexLock lock(mutex_);
  // A clock that was set far back would stop the filling.
  if (now < filled_) filled_ = now;
  FillLocked(now);
  if (left_ >= 1) {
    left_ -= 1;
    return absl::ZeroDuration();
  }
  return std::max(absl::Milliseconds(1), absl::Seconds((1 - left_) / per_second_));
}

bool RateBucket::IsFull(absl::Time now) {
  const MutexLock lock(mutex_);
  FillLocked(now);
  return left_ >= most_;
}

std::shared_ptr<RateBucket> RateLimit::BucketOf(absl::string_view client, absl::Time now) {
  if (per_second_ == 0) return nullptr;
  const MutexLock lock(mutex_);
  if (const auto it = buckets_.find(client); it != buckets_.end()) return it->second;
  if (buckets_.size() >= std::min(sweep_at_, max_clients_)) {
    // A full bucket that is not in use equals a new one.
    absl::erase_if(buckets_, [now](const auto& entry) {
      return entry.second.use_count() == 1 && entry.second->IsFull(now);
    });
    sweep_at_ = std::max<std::size_t>(1024, 2 * buckets_.size());
  }
  const absl::string_view name = buckets_.size() >= max_clients_ ? kLatecomers : client;
  std::shared_ptr<RateBucket>& bucket = buckets_[name];
  if (bucket == nullptr) bucket = std::make_shared<RateBucket>(per_second_, now);
  return bucket;
}

std::size_t RateLimit::clients() const {
  const MutexLock lock(mutex_);
  return buckets_.size();
}

}  // namespace dynmesh::server
