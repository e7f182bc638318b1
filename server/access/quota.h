// Counted limits, of which callers have shares while they live. Thread-safe.
#ifndef DYNMESH_SERVER_ACCESS_QUOTA_H_
#define DYNMESH_SERVER_ACCESS_QUOTA_H_

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

namespace dynmesh::server {

class Quota;

// A share of a quota, returned on destruction. Empty: refused.
class Share {
 public:
  Share() = default;
  Share(Share&& other) noexcept
      : used_(std::move(other.used_)), amount_(std::exchange(other.amount_, 0)) {}
  Share& operator=(Share&& other) noexcept {
    Release();
    used_ = std::move(other.used_);
    amount_ = std::exchange(other.amount_, 0);
    return *this;
  }
  ~Share() { Release(); }

  explicit operator bool() const { return used_ != nullptr; }
  void Release() {
    if (used_ != nullptr) used_->fetch_sub(amount_, std::memory_order_relaxed);
    used_.reset();
  }

 private:
  friend class Quota;
  Share(std::shared_ptr<std::atomic<std::uint64_t>> used, std::uint64_t amount)
      : used_(std::move(used)), amount_(amount) {}
  // Shared, because a call may outlive the server that admitted it.
  std::shared_ptr<std::atomic<std::uint64_t>> used_;
  std::uint64_t amount_ = 0;
};

class Quota {
 public:
  explicit Quota(std::uint64_t limit)
      : limit_(limit), used_(std::make_shared<std::atomic<std::uint64_t>>(0)) {}

  // An empty lease if that would pass the limit, or `most`.
  Share Take(std::uint64_t amount = 1,
             std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) {
    most = std::min(most, limit_);
    std::uint64_t used = used_->load(std::memory_order_relaxed);
    do {
      if (amount > most || used > most - amount) return Share();
    } while (!used_->compare_exchange_weak(used, used + amount, std::memory_order_relaxed));
    return Share(used_, amount);
  }

  std::uint64_t used() const { return used_->load(std::memory_order_relaxed); }
  std::uint64_t limit() const { return limit_; }

 private:
  const std::uint64_t limit_;
  std::shared_ptr<std::atomic<std::uint64_t>> used_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_QUOTA_H_
