// Until when an owner may answer reads without asking the database. It stops before the database
// would let another server claim its meshes; so no read is answered from a state that another
// server has already gone beyond. Thread-safe.
//
// Times are durations since the machine's start, by a clock that no setting of the time moves and
// that goes on while the machine sleeps. The clocks of two machines are never compared.
#ifndef DYNMESH_SERVER_CLUSTER_READ_LEASE_H_
#define DYNMESH_SERVER_CLUSTER_READ_LEASE_H_

#include <atomic>
#include <chrono>
#include <cstdint>

namespace dynmesh::server {

class ReadLease {
 public:
  // `ttl` > 0: as of the lease in the database. A fifth of it is left out: the clocks of the server
  // and the database may differ in speed by that much.
  explicit ReadLease(std::chrono::nanoseconds ttl) : span_((ttl - ttl / 5).count()) {}

  // A renewal succeeded that was sent at `sent`. That is before the database's lease began, however
  // long the answer took. Renewals may be told in any order.
  void Renewed(std::chrono::nanoseconds sent);
  // The lease was given up or lost: nothing is fresh any more, whatever renewal is told later.
  void End() { until_ = kEnded; }

  // True if a read may be answered at `now`. To be asked after the state was read, with a time
  // taken after that: a pause of the process between both is noticed then.
  bool IsFresh(std::chrono::nanoseconds now) const { return now.count() < until_; }

 private:
  static constexpr std::int64_t kNever = INT64_MIN + 1, kEnded = INT64_MIN;

  const std::int64_t span_;
  std::atomic<std::int64_t> until_{kNever};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CLUSTER_READ_LEASE_H_
