// Prefetching for operations in random order. The queue knows which ones come next.
#ifndef DYNMESH_CORE_SAC_PREFETCH_H_
#define DYNMESH_CORE_SAC_PREFETCH_H_

namespace dynmesh::sac {

// Prefetches what the next operations will read, in steps: each step reads the address that the
// step before has fetched. operation(entry) is anything with a `kind` and an `item`. Does nothing
// unless the program has kPrefetchSteps and Prefetch(kind, item, step).
template <class Program, class Queue, class Operation>
void PrefetchAhead(const Program& program, const Queue& queue, Operation operation) {
  if constexpr (requires { Program::kPrefetchSteps; }) {
    constexpr int kApart = 2;  // operations
    for (int step = 0; step < Program::kPrefetchSteps; ++step) {
      const auto* const soon = queue.Ahead((Program::kPrefetchSteps - step) * kApart - 1);
      if (soon == nullptr) continue;
      const auto& next = operation(*soon);
      program.Prefetch(next.kind, next.item, step);
    }
  }
}

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_PREFETCH_H_
