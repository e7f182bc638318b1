#include "server/base/memory_guard.h"

#include <malloc.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "dynmesh/options.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

// Trimming walks the whole heap, so it is not done at every tick.
constexpr int kTicksBetweenTrims = 10;

// From this many streams on, the memory they leave is worth a trim.
constexpr std::uint64_t kManyStreams = 64;

}  // namespace

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
