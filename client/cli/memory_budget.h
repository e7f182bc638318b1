// How much memory a command may take before it ends with an error, instead of being killed.
#ifndef DYNMESH_CLIENT_CLI_MEMORY_BUDGET_H_
#define DYNMESH_CLIENT_CLI_MEMORY_BUDGET_H_

#include <cstdint>
#include <new>
#include <string>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace dynmesh::cli {

class MemoryBudget {
 public:
  // `text` of --max-memory: a number of bytes, or one with K, M, G or T (powers of 1024). Empty:
  // three quarters of the least of the machine's memory, what of it is available now, the limits of
  // the process's cgroups, and its limits by setrlimit (`ulimit -v`). The last quarter is for an
  // array that doubles. INVALID_ARGUMENT for other texts.
  static absl::StatusOr<MemoryBudget> Parse(const std::string& text);

  std::uint64_t bytes() const { return bytes_; }
  // More vertices than this certainly do not fit: of a mesh from scratch.
  std::uint64_t MostVertices(int dimension) const;
  // True once the process takes more. Cheap: looks once in some thousand calls.
  bool IsExceeded() {
    if (calls_++ % kCallsBetweenLooks == 0 && !exceeded_) Look();
    return exceeded_;
  }
  bool was_exceeded() const { return exceeded_; }
  // RESOURCE_EXHAUSTED.
  absl::Status Error() const;
  std::string Text() const;  // "3.07 GB of memory"

 private:
  static constexpr std::uint32_t kCallsBetweenLooks = 4096;

  explicit MemoryBudget(std::uint64_t bytes) : bytes_(bytes) {}
  void Look();

  std::uint64_t bytes_;
  std::uint32_t calls_ = 0;
  bool exceeded_ = false;
};

// make() with Error() for its result if it is interrupted by IsExceeded(), or an allocation fails.
template <class Make>
auto WithinMemory(const MemoryBudget& budget, Make make) -> decltype(make()) {
  try {
    auto made = make();
    if (absl::IsCancelled(made.status()) && budget.was_exceeded()) return budget.Error();
    return made;
  } catch (const std::bad_alloc&) {  // beyond what was looked at
    return budget.Error();
  }
}

// --max-memory
void AddMemoryFlag(CLI::App& command, std::string& text);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_MEMORY_BUDGET_H_
