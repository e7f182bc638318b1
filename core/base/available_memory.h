// How much memory a process may use. Reads the system's files; thread-safe.
#ifndef DYNMESH_CORE_BASE_AVAILABLE_MEMORY_H_
#define DYNMESH_CORE_BASE_AVAILABLE_MEMORY_H_

#include <cstdint>
#include <string>

namespace dynmesh {

// The machine's memory, or the limit of the process's cgroup or an ancestor of it if that is less.
// The parameters `own` and `groups` are the system's files, for tests.
std::uint64_t AvailableBytes(const std::string& own = "/proc/self/cgroup",
                             const std::string& groups = "/sys/fs/cgroup");

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_AVAILABLE_MEMORY_H_
