// Stops the growth of meshes when the process is at its memory limit. The server's ticker measures
// the resident size periodically; a check costs one load. Thread-safe.
#ifndef DYNMESH_SERVER_BASE_MEMORY_GUARD_H_
#define DYNMESH_SERVER_BASE_MEMORY_GUARD_H_

#include <atomic>
#include <cstdint>

#include "absl/status/status.h"
#include "core/base/available_memory.h"
#include "server/base/process.h"

namespace dynmesh::server {

class MemoryGuard {
 public:
  using Measurement = std::uint64_t (*)();

  // `limit` in bytes, of what `measurement` returns. 0: nine tenths of AvailableBytes().
  explicit MemoryGuard(std::uint64_t limit, Measurement measurement = &ResidentBytes);

  // Measures the process. If it is over the limit, makes the allocator release free memory.
  void Measure();

  // Gets the number of open streams at each tick. When more than half of many streams have ended,
  // makes the allocator release their memory. By the ticker only.
  void NoteStreams(std::uint64_t open);

  // RESOURCE_EXHAUSTED (MEMORY_LIMIT, with RetryInfo) if nothing may grow.
  absl::Status CheckRoom() const;
  // That error, for work interrupted by full().
  absl::Status RefuseGrowth() const;
  std::uint64_t limit() const { return limit_; }
  // Vertices of a mesh that takes half of the limit: during a rebuild a mesh exists twice.
  std::uint64_t MostVertices(int dimension) const;
  // True while nothing may grow. For work that can be interrupted.
  const std::atomic<bool>* full() const { return &full_; }

 private:
  const std::uint64_t limit_;
  const Measurement measurement_;
  std::atomic<bool> full_{false};
  int ticks_over_ = 0;              // used by the ticker only, as most_streams_
  std::uint64_t most_streams_ = 0;  // since the allocator was last asked
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_MEMORY_GUARD_H_
