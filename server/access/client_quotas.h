// A quota per client, named as in Pass::client(). Clients without leases are forgotten.
// Thread-safe; Take costs a lock and a look-up.
#ifndef DYNMESH_SERVER_ACCESS_CLIENT_QUOTAS_H_
#define DYNMESH_SERVER_ACCESS_CLIENT_QUOTAS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/string_view.h"
#include "server/access/quota.h"

namespace dynmesh::server {

class ClientQuotas {
 public:
  // `limit` is per client. 0: no limit.
  explicit ClientQuotas(std::uint64_t limit) : limit_(limit) {}

  // An empty lease if the client is at its limit.
  Lease Take(absl::string_view client) {
    const std::lock_guard lock(mutex_);
    if (quotas_.size() >= sweep_at_) {
      absl::erase_if(quotas_, [](const auto& entry) { return entry.second.used() == 0; });
      sweep_at_ = std::max(kFirstSweep, 2 * quotas_.size());
    }
    return quotas_.try_emplace(client, limit_ != 0 ? limit_ : kAny).first->second.Take();
  }

  std::uint64_t limit() const { return limit_; }
  // The largest use of a client.
  std::uint64_t most() const {
    const std::lock_guard lock(mutex_);
    std::uint64_t most = 0;
    for (const auto& [client, quota] : quotas_) most = std::max(most, quota.used());
    return most;
  }
  // Number of clients held.
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return quotas_.size();
  }

 private:
  static constexpr std::size_t kFirstSweep = 1024;
  static constexpr std::uint64_t kAny = std::numeric_limits<std::uint64_t>::max();

  const std::uint64_t limit_;
  mutable std::mutex mutex_;
  absl::flat_hash_map<std::string, Quota> quotas_;
  std::size_t sweep_at_ = kFirstSweep;  // number of clients at which unused ones are removed
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_CLIENT_QUOTAS_H_
