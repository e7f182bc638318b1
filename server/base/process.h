// What the kernel tells of this process, and is told. Thread-safe; what counts reads /proc.
#ifndef DYNMESH_SERVER_BASE_PROCESS_H_
#define DYNMESH_SERVER_BASE_PROCESS_H_

#include <cstdint>

namespace dynmesh::server {

// Memory that it has; 0 where it cannot be told.
std::uint64_t ResidentBytes();

// Files and connections that are open, the one that counts them aside; 0 where it cannot be told.
std::uint64_t OpenDescriptors();

// The calling thread gets a tenth of the time of others, where there are not cores for all.
void YieldToOtherThreads();

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_PROCESS_H_
