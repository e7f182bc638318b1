// What a program is, for Engine and UntracedEngine (engine.h): procedures over items. docs/engine.md
// has the rules, examples/maximum_program.h is a small one. REQUIRES of a program:
//   PayloadOf<Program>::Type                  what it keeps per operation (trivially copyable)
//   Priority(kind, item) -> uint64            uniform; a function of what the item *is*
//   Before(kind, item, kind, item) -> bool    strict order among equal priorities
//   OperationsOf(kind, item) -> OpId&         head of the item's chain, initially kNoOp
//   Execute(Context&)                         the procedures, the same for every engine
//   Publish(output, Stamp) Withdraw(output, Stamp)   make an output visible / invisible
//                                             from that time on, and Notify
//   Release(output)                           after the propagation, once for each Withdraw:
//                                             forget it, unless it was published again
// and may have:
//   IsAttentive(kind, payload) -> bool        does NotifyAttentive reach it? As executed last
//   kPrefetchSteps, Prefetch(kind, item, step)   see prefetch.h
#ifndef DYNMESH_CORE_SAC_PROGRAM_H_
#define DYNMESH_CORE_SAC_PROGRAM_H_

#include <cstdint>

namespace dynmesh::sac {

using Kind = std::uint8_t;
using Item = std::uint32_t;
using Output = std::uint32_t;

// Specialised for each program before the program's class is complete.
template <class Program>
struct PayloadOf;

// Limits of one operation's lists, and of the number of operations. Where one is exceeded the
// propagation ends, and the excessive operation is not committed (Engine::Propagate). Tests set
// lower ones.
struct EngineLimits {
  std::uint32_t outputs = (1u << 16) - 1, places = (1u << 16) - 1;
  std::uint32_t requests = (1u << 24) - 1, reads = (1u << 24) - 1;
  // Half of the range of OpId: an undo makes at most as many operations again as were dropped.
  std::uint32_t operations = 1u << 31;
};

// What an engine has done.
struct Counters {
  std::uint64_t executed = 0;   // bodies run
  std::uint64_t created = 0;    // operations that are new
  std::uint64_t dropped = 0;    // operations that are gone
  std::uint64_t unchanged = 0;  // re-executed to the same outputs and requests
  std::uint64_t notified = 0;   // subscribers looked at by Notify
};

// For Propagate: runs to the end.
struct NoInterrupt {
  bool operator()() const { return false; }
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_PROGRAM_H_
