#include "server/cluster/read_lease.h"

namespace dynmesh::server {

void ReadLease::Renewed(std::chrono::nanoseconds sent) {
  const std::int64_t until = sent.count() + span_;
  std::int64_t before = until_;
  while (before != kEnded && before < until && !until_.compare_exchange_weak(before, until)) {
  }
}

}  // namespace dynmesh::server
