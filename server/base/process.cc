#include "server/base/process.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <system_error>

#include "server/base/log.h"

namespace dynmesh::server {

std::uint64_t ResidentBytes() {
  std::uint64_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::uint64_t OpenDescriptors() {
  std::error_code error;
  std::uint64_t count = 0;
  for (std::filesystem::directory_iterator it("/proc/self/fd", error), end; !error && it != end;
       it.increment(error)) {
    ++count;
  }
  return count == 0 ? 0 : count - 1;
}

void YieldToOtherThreads() {
  // Linux takes 0 as the calling thread, not the process. Nice 10 gives weight 110 against 1024.
  if (setpriority(PRIO_PROCESS, 0, 10) == 0) return;
  static std::once_flag told;
  std::call_once(told, [error = errno] {
    Log(LogLevel::kWarning, "priority_refused",
        {{"error", std::strerror(error)},
         {"message", "edits wait behind readers where there are not cores for all"}});
  });
}

}  // namespace dynmesh::server
