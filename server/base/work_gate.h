// Counts running work. A drain closes the gate to refuse new work, then waits for the rest.
// Thread-safe.
#ifndef DYNMESH_SERVER_BASE_WORK_GATE_H_
#define DYNMESH_SERVER_BASE_WORK_GATE_H_

#include <chrono>
#include <cstddef>
#include <memory>

#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class WorkGate {
 public:
  // Held while the work runs; may outlive the gate. Null: refused.
  using Ticket = std::shared_ptr<void>;

  // Null if the gate is closed.
  Ticket Enter() {
    const MutexLock lock(state_->mutex);
    if (state_->closed) return nullptr;
    ++state_->count;
    // The deleter runs when the last copy is released.
    return Ticket(state_.get(), [state = state_](void*) {
      const MutexLock leaving(state->mutex);
      if (--state->count == 0) state->empty.NotifyAll();
    });
  }

  void Close() {
    const MutexLock lock(state_->mutex);
    state_->closed = true;
  }

  bool closed() const {
    const MutexLock lock(state_->mutex);
    return state_->closed;
  }

  // Blocks until no work runs. False after `limit`.
  bool WaitEmpty(absl::Duration limit) const {
    const MutexLock lock(state_->mutex);
    return state_->empty.WaitFor(
        state_->mutex, absl::ToChronoNanoseconds(limit),
        [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(state_->mutex) { return state_->count == 0; });
  }

 private:
  struct State {
    Mutex mutex;
    CondVar empty;
    std::size_t count ABSL_GUARDED_BY(mutex) = 0;
    bool closed ABSL_GUARDED_BY(mutex) = false;
  };
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_WORK_GATE_H_
