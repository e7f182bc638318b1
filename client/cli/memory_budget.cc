#include "client/cli/memory_budget.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>

#include "absl/strings/str_format.h"
#include "core/base/available_memory.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

// The least memory of a mesh while it is made from scratch, a vertex, measured with uniform points
// and with segments side by side: rounded down.
constexpr std::uint64_t kLeastBytesPerVertex2D = 300;
constexpr std::uint64_t kLeastBytesPerVertex3D = 700;

// What limits the process's address space; kNoLimit if nothing does.
std::uint64_t LimitOfSpace() {
  std::uint64_t least = kNoLimit;
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
  return kNoLimit;
}

// What the process takes: its resident pages; its address space, if that has a limit.
std::uint64_t Taken() {
  std::uint64_t space = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> space >> resident;
  const std::uint64_t pages = LimitOfSpace() == kNoLimit ? resident : space;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

absl::StatusOr<MemoryBudget> MemoryBudget::Parse(const std::string& text) {
  if (text.empty()) {
    return MemoryBudget(std::min({AvailableBytes(), FreeNow(), LimitOfSpace()}) / 4 * 3);
  }
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string unit(static_cast<const char*>(end), text.data() + text.size());
  constexpr std::string_view kUnits = "KMGT";
  const std::size_t power = unit.size() == 1 ? kUnits.find(unit[0]) : kUnits.npos;
  const bool is_unit = unit.empty() || power != kUnits.npos;
  for (std::size_t i = 0; is_unit && !unit.empty() && i <= power; ++i) number *= 1024;
  if (error != std::errc() || !is_unit || !(number >= 1) || !(number < 1e18)) {
    return absl::InvalidArgumentError(
        Concat("--max-memory: expected a number of bytes such as 4000000000, 500M or 4G, found ",
               text::Quoted(text)));
  }
  return MemoryBudget(static_cast<std::uint64_t>(number));
}

std::uint64_t MemoryBudget::MostVertices(int dimension) const {
  constexpr std::uint64_t kAlways = 10'000;  // a few megabytes, as the process itself takes
  return std::max(kAlways,
                  bytes_ / (dimension == 2 ? kLeastBytesPerVertex2D : kLeastBytesPerVertex3D));
}

void MemoryBudget::Look() { exceeded_ = Taken() > bytes_; }

std::string MemoryBudget::Text() const {
  return absl::StrFormat("%.3g GB of memory", static_cast<double>(bytes_) / 1e9);
}

absl::Status MemoryBudget::Error() const {
  return absl::ResourceExhaustedError(
      Concat("the mesh takes more than ", Text(), " while it is made; --max-memory allows more"));
}

void AddMemoryFlag(CLI::App& command, std::string& text) {
  command
      .add_option("--max-memory", text,
                  "Give up when the command takes more memory, in bytes or as 500M or 4G (default: "
                  "three quarters of what the machine, its control groups and `ulimit -v` leave)")
      ->type_name("BYTES");
}

}  // namespace dynmesh::cli
