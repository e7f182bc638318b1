// Counts running work. A drain closes the gate to refuse new work, then waits for the rest.
// Thread-safe.
#ifndef DYNMESH_SERVER_BASE_WORK_GATE_H_
#define DYNMESH_SERVER_BASE_WORK_GATE_H_

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>

#include "absl/time/time.h"

namespace dynmesh::server {

class WorkGate {
 public:
  // Held while the work runs; may outlive the gate. Null: refused.
  using Ticket = std::shared_ptr<void>;

  // Null if the gate is closed.
  Ticket Enter() {
    const std::lock_guard lock(state_->mutex);
    if (state_->closed) return nullptr;
    ++state_->count;
    // The deleter runs when the last copy is released.
    return Ticket(state_.get(), [state = state_](void*) {
      const std::lock_guard leaving(state->mutex);
      if (--state->count == 0) state->empty.notify_all();
    });
  }

  void Close() {
    const std::lock_guard lock(state_->mutex);
    state_->closed = true;
  }

  bool closed() const {
    const std::lock_guard lock(state_->mutex);
    return state_->closed;
  }

  // Blocks until no work runs. False after `limit`.
  bool WaitEmpty(absl::Duration limit) const {
    std::unique_lock lock(state_->mutex);
    return state_->empty.wait_for(lock, absl::ToChronoNanoseconds(limit),
                                  [this] { return state_->count == 0; });
  }

 private:
  struct State {
    std::mutex mutex;
    std::condition_variable empty;
    std::size_t count = 0;
    bool closed = false;
  };
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_WORK_GATE_H_
