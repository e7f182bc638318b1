// Keeps meshes from growing when the process has all the memory that it may have. The resident
// size is measured at intervals, by the server's ticker; between two of them asking costs one
// load. Thread-safe.
#ifndef DYNMESH_SERVER_BASE_MEMORY_GUARD_H_
#define DYNMESH_SERVER_BASE_MEMORY_GUARD_H_

#include <atomic>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/base/process.h"

namespace dynmesh::server {

// Of the machine or, where that is less, of the control group that the process is in, or one that
// this is in. For tests, where the system tells of groups.
std::uint64_t AvailableBytes(const std::string& own = "/proc/self/cgroup",
                             const std::string& groups = "/sys/fs/cgroup");

class MemoryGuard {
 public:
  using Measurement = std::uint64_t (*)();

  // Of what `measurement` returns, in bytes. 0: nine tenths of what there is.
  explicit MemoryGuard(std::uint64_t limit, Measurement measurement = &ResidentBytes);

  // Looks at the process; if it has too much, asks the allocator to give back what is free.
  void Measure();

  // Told, as often as it measures, how many streams are open: when of many most have ended, the
  // allocator is asked to give back what they left. By the ticker only.
  void NoteStreams(std::uint64_t open);

  // RESOURCE_EXHAUSTED (MEMORY_LIMIT, with RetryInfo) if nothing may grow.
  absl::Status CheckRoom() const;
  // That error, for who was stopped in the middle.
  absl::Status RefuseGrowth() const;
  std::uint64_t limit() const { return limit_; }
  // Of a mesh that takes half of the limit: a mesh that is made anew is there twice for a while.
  std::uint64_t MostVertices(int dimension) const;
  // True while nothing may grow: for what may be stopped in the middle.
  const std::atomic<bool>* full() const { return &full_; }

 private:
  const std::uint64_t limit_;
  const Measurement measurement_;
  std::atomic<bool> full_{false};
  int ticks_over_ = 0;              // the ticker's, as what follows
  std::uint64_t most_streams_ = 0;  // since the allocator was last asked
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_MEMORY_GUARD_H_
