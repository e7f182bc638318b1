#include "server/base/memory_guard.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "dynmesh/options.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

// Trimming walks the whole heap, so it is not done at every tick.
constexpr int kTicksBetweenTrims = 10;

// From this many streams on, the memory they leave is worth a trim.
constexpr std::uint64_t kManyStreams = 64;

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

// The number in a file; kNoLimit if the file is missing or says "max".
std::uint64_t NumberIn(const std::string& path) {
  std::string word;
  std::ifstream(path) >> word;
  std::uint64_t number = 0;
  return absl::SimpleAtoi(word, &number) ? number : kNoLimit;
}

// The least value of the files `name` of a group and its ancestors up to the root.
std::uint64_t LeastUpwards(const std::string& root, std::string group, const std::string& name) {
  std::uint64_t least = kNoLimit;
  while (true) {
    least = std::min(least, NumberIn(absl::StrCat(root, group, "/", name)));
    if (group.empty()) return least;
    group.resize(std::min(group.rfind('/'), group.size() - 1));
  }
}

// A line is NUMBER:CONTROLLERS:/PATH; CONTROLLERS is empty for cgroup version 2. In a container the
// path may be the host's and not exist: then the root's limit counts.
std::uint64_t LimitOfGroup(const std::string& own, const std::string& groups) {
  std::uint64_t least = kNoLimit;
  std::ifstream lines(own);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> part = absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (part.size() != 3) continue;
    const std::string group = part[2] == "/" ? "" : part[2];
    if (part[1].empty()) {
      least = std::min(least, LeastUpwards(groups, group, "memory.max"));
    } else if (part[1] == "memory") {
      least = std::min(least, LeastUpwards(groups + "/memory", group, "memory.limit_in_bytes"));
    }
  }
  return least;
}

}  // namespace

std::uint64_t AvailableBytes(const std::string& own, const std::string& groups) {
  const auto machine = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                       static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return std::min(machine, LimitOfGroup(own, groups));
}

MemoryGuard::MemoryGuard(std::uint64_t limit, Measurement measurement)
    : limit_(limit != 0 ? limit : AvailableBytes() / 10 * 9), measurement_(measurement) {
  Measure();
}

void MemoryGuard::Measure() {
  const std::uint64_t resident = measurement_();
  const bool over = resident > limit_;
  const bool was_over = full_.exchange(over, std::memory_order_relaxed);
  if (over != was_over) {
    Log(over ? LogLevel::kWarning : LogLevel::kInfo, over ? "memory_limit" : "memory_room",
        {{"resident", resident}, {"limit", limit_}});
  }
  if (!over) {
    ticks_over_ = 0;
  } else if (ticks_over_++ % kTicksBetweenTrims == 0) {
    malloc_trim(0);
  }
}

std::uint64_t MemoryGuard::MostVertices(int dimension) const {
  // Includes the trace and the process's overhead. The maximum measured with uniform points.
  const std::uint64_t bytes_per_vertex = dimension == 2 ? 1'000 : 2'500;
  constexpr std::uint64_t kLeast = 100'000;
  return std::clamp(limit_ / 2 / bytes_per_vertex, kLeast, dynmesh::MostVertices(dimension));
}

void MemoryGuard::NoteStreams(std::uint64_t open) {
  most_streams_ = std::max(most_streams_, open);
  if (most_streams_ < kManyStreams || open > most_streams_ / 2) return;
  most_streams_ = open;
  malloc_trim(0);
}

absl::Status MemoryGuard::CheckRoom() const {
  return full_.load(std::memory_order_relaxed) ? RefuseGrowth() : absl::OkStatus();
}

absl::Status MemoryGuard::RefuseGrowth() const {
  codec::ServiceError error;
  error.reason = codec::reason::kMemoryLimit;
  error.retry_after = absl::Seconds(1);
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat("the server has its limit of ", limit_,
                   " bytes of memory: nothing may grow until something is removed"),
      error);
}

}  // namespace dynmesh::server
