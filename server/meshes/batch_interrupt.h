// What a mesh asks between the operations of a batch.
#ifndef DYNMESH_SERVER_MESHES_BATCH_INTERRUPT_H_
#define DYNMESH_SERVER_MESHES_BATCH_INTERRUPT_H_

#include <atomic>
#include <functional>

#include "server/base/time_slice.h"

namespace dynmesh::server {

// For ApplyOptions::interrupted: lets waiting threads run, and is true once one of the flags is
// set. A flag may be null, and must outlive the function. For one thread.
inline std::function<bool()> BatchInterrupt(const std::atomic<bool>* cancelled,
                                            const std::atomic<bool>* full) {
  const auto is_set = [](const std::atomic<bool>* flag) {
    return flag != nullptr && flag->load(std::memory_order_relaxed);
  };
  return [=, slice = TimeSlice()]() mutable {
    slice.Step();
    return is_set(cancelled) || is_set(full);
  };
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_BATCH_INTERRUPT_H_
