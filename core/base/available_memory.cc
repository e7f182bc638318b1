#include "core/base/available_memory.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>

namespace dynmesh {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

// The number in a file; kNoLimit if the file is missing or says "max".
std::uint64_t NumberIn(const std::string& path) {
  std::string word;
  std::ifstream(path) >> word;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc() && end == word.data() + word.size() ? number : kNoLimit;
}

// The least value of the files `name` of a group and its ancestors up to the root.
std::uint64_t LeastUpwards(const std::string& root, std::string group, const std::string& name) {
  std::uint64_t least = kNoLimit;
  while (true) {
    least = std::min(least, NumberIn(root + group + "/" + name));
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
    const std::size_t first = line.find(':');
    const std::size_t second = first == line.npos ? first : line.find(':', first + 1);
    if (second == line.npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const std::string path = line.substr(second + 1), group = path == "/" ? "" : path;
    if (controllers.empty()) {
      least = std::min(least, LeastUpwards(groups, group, "memory.max"));
    } else if (controllers == "memory") {
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

}  // namespace dynmesh
