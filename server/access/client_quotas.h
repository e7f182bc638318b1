// A quota per client, named as in Pass::client(). Clients without leases are forgotten.
// Thread-safe; Take costs a lock and a look-up.
#ifndef DYNMESH_SERVER_ACCESS_CLIENT_QUOTAS_H_
#define DYNMESH_SERVER_ACCESS_CLIENT_QUOTAS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "core/base/mutex.h"
#include "server/access/quota.h"

namespace dynmesh::server {

class ClientQuotas {
 public:
  static constexpr std::uint64_t kAny = std::numeric_limits<std::uint64_t>::max();

  // `limit` is per client. 0: no limit.
  explicit ClientQuotas(std::uint64_t limit) : limit_(limit) {}

  // An empty lease if that would pass the client's limit, or `most`.
  Share Take(absl::string_view client, std::uint64_t amount = 1, std::uint64_t most = kAny) {
    const MutexLock lock(mutex_);
    if (quotas_.size() >= sweep_at_) {
      absl::erase_if(quotas_, [](const auto& entry) { return entry.second.used() == 0; });
      sweep_at_ = std::max(kFirstSweep, 2 * quotas_.size());
    }
    return quotas_.try_emplace(client, limit_ != 0 ? limit_ : kAny)
        .first->second.Take(amount, most);
  }

  std::uint64_t limit() const { return limit_; }
  // The largest use of a client.
  std::uint64_t most() const {
    const MutexLock lock(mutex_);
    std::uint64_t most = 0;
    for (const auto& [client, quota] : quotas_) most = std::max(most, quota.used());
    return most;
  }
  // The `count` clients with the largest use, and their use: "token a 32, token b 5".
  std::string Largest(std::size_t count) const {
    std::vector<std::pair<std::uint64_t, absl::string_view>> users;
    const MutexLock lock(mutex_);
    for (const auto& [client, quota] : quotas_) {
      if (quota.used() > 0) users.emplace_back(quota.used(), client);
    }
    const auto end = users.begin() + static_cast<std::ptrdiff_t>(std::min(count, users.size()));
    std::partial_sort(users.begin(), end, users.end(), std::greater<>());
    return absl::StrJoin(users.begin(), end, ", ", [](std::string* out, const auto& user) {
      absl::StrAppend(out, user.second, " ", user.first);
    });
  }
  // Number of clients held.
  std::size_t size() const {
    const MutexLock lock(mutex_);
    return quotas_.size();
  }

 private:
  static constexpr std::size_t kFirstSweep = 1024;

  const std::uint64_t limit_;
  mutable Mutex mutex_;
  absl::flat_hash_map<std::string, Quota> quotas_ ABSL_GUARDED_BY(mutex_);
  // Number of clients at which unused ones are removed.
  std::size_t sweep_at_ ABSL_GUARDED_BY(mutex_) = kFirstSweep;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_CLIENT_QUOTAS_H_
