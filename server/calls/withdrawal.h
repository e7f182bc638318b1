// Withdraws the job of a call that its client has cancelled.
#ifndef DYNMESH_SERVER_CALLS_WITHDRAWAL_H_
#define DYNMESH_SERVER_CALLS_WITHDRAWAL_H_

#include <atomic>
#include <memory>
#include <utility>

#include "core/base/mutex.h"
#include "server/meshes/mesh_host.h"

namespace dynmesh::server {

// The flag that the job polls, and the mesh where it waits. The client may cancel before the mesh
// is known. Thread-safe.
class Withdrawal {
 public:
  using HostPtr = std::shared_ptr<MeshHost>;

  // Once, before the job is submitted.
  void Take(HostPtr host) {
    const MutexLock lock(mutex_);
    host_ = std::move(host);
  }
  void Cancel() {
    cancelled_->store(true);
    HostPtr host;
    {
      const MutexLock lock(mutex_);
      host = host_;
    }
    if (host != nullptr) host->Withdraw(cancelled_);
  }

  const std::shared_ptr<std::atomic<bool>>& cancelled() const { return cancelled_; }
  // REQUIRES: Take has returned. Needs no lock: that is the only change.
  const MeshHost& host() const ABSL_NO_THREAD_SAFETY_ANALYSIS { return *host_; }

 private:
  const std::shared_ptr<std::atomic<bool>> cancelled_ = std::make_shared<std::atomic<bool>>(false);
  Mutex mutex_;
  HostPtr host_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_WITHDRAWAL_H_
