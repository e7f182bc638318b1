// Renews a node's leases from a thread of its own, twice in a lease, until it is stopped. (More
// often, and other nodes would wait longer for the end of a dead one's lease.)
//
// A renewal that fails is tried again after a tenth of a lease: as long as the lease in the
// database has not run out nothing is lost, and afterwards the lease for reads has ended before.
// One that hangs delays the next ones; the lease for reads runs out meanwhile, as it counts from
// the sending. Thread-safe.
#ifndef DYNMESH_SERVER_CLUSTER_LEASE_KEEPER_H_
#define DYNMESH_SERVER_CLUSTER_LEASE_KEEPER_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <thread>

#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "server/base/boot_time.h"
#include "server/cluster/read_lease.h"

namespace dynmesh::server {

class LeaseKeeper {
 public:
  struct Calls {
    std::function<absl::Status()> renew;    // blocks until the database answered
    std::function<absl::Status()> give_up;  // once, at the end, after the last `renew` returned
  };

  // Renews at once, in the thread. `ttl` > 0: of the leases.
  LeaseKeeper(std::chrono::nanoseconds ttl, Calls calls);
  // As Stop.
  ~LeaseKeeper() { Stop(); }
  LeaseKeeper(const LeaseKeeper&) = delete;
  LeaseKeeper& operator=(const LeaseKeeper&) = delete;

  // Ends the lease for reads, then the renewals, then gives the leases up. Waits for a renewal
  // under way. Only the first call does anything. Not to be called by two threads at once.
  void Stop();

  // True if a read that has been made may be answered: see ReadLease::IsFresh.
  bool MayAnswerReads() const { return reads_.IsFresh(BootTime()); }
  // Since the sending of the last renewal that succeeded; negative: none did.
  std::chrono::nanoseconds Age() const;

 private:
  void Run();

  const std::chrono::nanoseconds period_, retry_;
  const Calls calls_;
  ReadLease reads_;
  std::atomic<std::int64_t> renewed_{-1};  // as BootTime
  Mutex mutex_;
  CondVar stopping_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CLUSTER_LEASE_KEEPER_H_
