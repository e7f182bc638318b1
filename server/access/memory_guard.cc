#include "server/access/memory_guard.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/base/process.h"

namespace dynmesh::server {
namespace {

// Trimming walks the whole heap: not at every tick.
constexpr int kTicksBetweenTrims = 10;

// What a file of one number says; everything, if it is not there or says "max".
std::uint64_t NumberIn(const char* path) {
  std::string word;
  std::ifstream(path) >> word;
  std::uint64_t number = 0;
  return absl::SimpleAtoi(word, &number) ? number : std::numeric_limits<std::uint64_t>::max();
}

}  // namespace

std::uint64_t AvailableBytes() {
  const auto machine = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                       static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return std::min({machine, NumberIn("/sys/fs/cgroup/memory.max"),
                   NumberIn("/sys/fs/cgroup/memory/memory.limit_in_bytes")});
}

MemoryGuard::MemoryGuard(std::uint64_t limit)
    : limit_(limit != 0 ? limit : AvailableBytes() / 10 * 9) {
  Measure();
}

void MemoryGuard::Measure() {
  const std::uint64_t resident = ResidentBytes();
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
