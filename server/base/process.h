// Figures and settings of this process in the kernel. Thread-safe; the figures read /proc.
#ifndef DYNMESH_SERVER_BASE_PROCESS_H_
#define DYNMESH_SERVER_BASE_PROCESS_H_

#include <cstdint>

namespace dynmesh::server {

// Resident memory; 0 if unknown.
std::uint64_t ResidentBytes();

// Open files and connections, without the descriptor used to count; 0 if unknown.
std::uint64_t OpenDescriptors();

// Lowers the calling thread's priority: with too few cores it gets a tenth of the time of others.
void YieldToOtherThreads();

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_PROCESS_H_
