// Durations that no setting of the clock changes. Thread-safe.
#ifndef DYNMESH_SERVER_BASE_BOOT_TIME_H_
#define DYNMESH_SERVER_BASE_BOOT_TIME_H_

#include <chrono>

namespace dynmesh::server {

// Since the machine's start, by CLOCK_BOOTTIME: it goes on while the machine sleeps.
std::chrono::nanoseconds BootTime();

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_BOOT_TIME_H_
