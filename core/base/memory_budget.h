// How much memory a process may take before what it does ends with an error, instead of the process
// being killed. For programs and modules; a mesh does not depend on it.
#ifndef DYNMESH_CORE_BASE_MEMORY_BUDGET_H_
#define DYNMESH_CORE_BASE_MEMORY_BUDGET_H_

#include <cstdint>
#include <new>
#include <string>

#include "absl/status/status.h"

namespace dynmesh {

// For one thread at a time.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t bytes) : bytes_(bytes) {}
  // What the process takes now, and three quarters of the least of what is left: of the machine's
  // memory, of the limits of its cgroups, and of those by setrlimit (`ulimit -v`). The last quarter
  // is for an array that doubles. Reads files of the system: some 100 µs.
  static MemoryBudget OfWhatIsLeft();

  std::uint64_t bytes() const { return bytes_; }
  // More vertices than this certainly do not fit: of a mesh from scratch.
  std::uint64_t MostVertices(int dimension) const;
  // True once the process takes more. Cheap: looks once in some thousand calls.
  bool IsExceeded() {
    if (calls_++ % kCallsBetweenLooks == 0 && !exceeded_) Look();
    return exceeded_;
  }
  bool was_exceeded() const { return exceeded_; }
  // RESOURCE_EXHAUSTED. `advice` is its end.
  absl::Status Error(const std::string& advice) const;
  std::string Text() const;  // "3.07 GB of memory"

  static constexpr std::uint32_t kCallsBetweenLooks = 4096;

 private:
  void Look();

  std::uint64_t bytes_;
  std::uint32_t calls_ = 0;
  bool exceeded_ = false;
};

// make() with Error(advice) for its result if it is interrupted by IsExceeded(), or an allocation
// fails.
template <class Make>
auto WithinMemory(const MemoryBudget& budget, const std::string& advice, Make make)
    -> decltype(make()) {
  try {
    auto made = make();
    if (absl::IsCancelled(made.status()) && budget.was_exceeded()) return budget.Error(advice);
    return made;
  } catch (const std::bad_alloc&) {  // beyond what was looked at
    return budget.Error(advice);
  }
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_MEMORY_BUDGET_H_
