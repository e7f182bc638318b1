// Random order is hard on caches, but the queue knows what comes next.
#ifndef DYNMESH_CORE_SAC_PREFETCH_H_
#define DYNMESH_CORE_SAC_PREFETCH_H_

namespace dynmesh::sac {

// Asks for what the operations taken soon will read, step by step, as each step reads where the one
// before has pointed. operation(entry) is anything with a `kind` and an `item`. A program that
// knows how has kPrefetchSteps and Prefetch(kind, item, step).
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
