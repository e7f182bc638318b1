#include "server/cluster/read_lease.h"

#include <ctime>

namespace dynmesh::server {

std::chrono::nanoseconds BootTime() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);  // cannot fail: the clock exists since Linux 2.6.39
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

void ReadLease::Renewed(std::chrono::nanoseconds sent) {
  const std::int64_t until = sent.count() + span_;
  std::int64_t before = until_;
  while (before != kEnded && before < until && !until_.compare_exchange_weak(before, until)) {
  }
}

}  // namespace dynmesh::server
