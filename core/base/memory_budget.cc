#include "core/base/memory_budget.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>

#include "core/base/available_memory.h"
#include "core/base/text.h"

namespace dynmesh {
namespace {

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

// The least memory of a mesh while it is made from scratch, a vertex, measured with uniform points
// and with segments side by side: rounded down.
constexpr std::uint64_t kLeastBytesPerVertex2D = 300;
constexpr std::uint64_t kLeastBytesPerVertex3D = 700;

// What limits the process's address space; kUnlimited if nothing does.
std::uint64_t LimitOfSpace() {
  std::uint64_t least = kUnlimited;
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    rlimit limit = {};
    if (getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
      least = std::min(least, static_cast<std::uint64_t>(limit.rlim_cur));
    }
  }
  return least;
}

// MemAvailable of /proc/meminfo.
std::uint64_t FreeNow() {
  std::ifstream lines("/proc/meminfo");
  std::string name, unit;
  for (std::uint64_t kilobytes = 0; lines >> name >> kilobytes; std::getline(lines, unit)) {
    if (name == "MemAvailable:") return kilobytes * 1024;
  }
  return kUnlimited;
}

// What the process takes: its resident pages; its address space, if that has a limit.
std::uint64_t Taken() {
  std::uint64_t space = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> space >> resident;
  const std::uint64_t pages = LimitOfSpace() == kUnlimited ? resident : space;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

MemoryBudget MemoryBudget::OfWhatIsLeft() {
  const std::uint64_t taken = Taken();
  const std::uint64_t limit = std::min(AvailableBytes(), LimitOfSpace());
  const std::uint64_t left = std::min(FreeNow(), limit - std::min(limit, taken));
  return MemoryBudget(taken + left / 4 * 3);
}

std::uint64_t MemoryBudget::MostVertices(int dimension) const {
  constexpr std::uint64_t kAlways = 10'000;  // a few megabytes, as the process itself takes
  return std::max(kAlways,
                  bytes_ / (dimension == 2 ? kLeastBytesPerVertex2D : kLeastBytesPerVertex3D));
}

void MemoryBudget::Look() { exceeded_ = Taken() > bytes_; }

std::string MemoryBudget::Text() const {
  char number[32];
  std::snprintf(number, sizeof(number), "%.3g", static_cast<double>(bytes_) / 1e9);
  return text::Concat(number, " GB of memory");
}

absl::Status MemoryBudget::Error(const std::string& advice) const {
  return absl::ResourceExhaustedError(
      text::Concat("the mesh takes more than ", Text(), " while it is made; ", advice));
}

}  // namespace dynmesh
